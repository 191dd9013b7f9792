#include <gtest/gtest.h>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/export/formats/shapes_json.h"
#include "nodes/shapes/load_shapes/read_shapes.h"
#include "runtime/json_text.h"
#include "tests/support/code_of.h"
#include "tests/support/replaced.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
using namespace load_shapes;

Mesh tetrahedron(double height) {
  return {{Vec3(0, 0, 0), Vec3(1.0 / 3, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, height)},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

// A plain shape, and one with a class, colors and texture coordinates that text easily changes.
Shapes two_kinds() {
  Shapes s;
  s.shapes.push_back(measure_shape("../a \"b\"", tetrahedron(0.7), 0.9));
  s.shapes.push_back(measure_shape("", tetrahedron(1e-3), 0.1));
  Shape& painted = s.shapes[1];
  painted.cls = 7;
  painted.smooth = true;
  painted.color = {Vec3f(0.1f, 0, 1), Vec3f(1e-40f, 2, 0.3f), Vec3f(-0.0f, 1, 1), Vec3f(0.2f, 0.3f, 0.4f)};
  painted.uv.assign(4, {Eigen::Vector2f(0.1f, 0.2f), Eigen::Vector2f(1, 0), Eigen::Vector2f(0.3f, 0.7f)});
  return s;
}

std::string text_of(const Shapes& s) { return json_text(exporting::json_with_meshes(s)); }

TEST(LoadShapes, GivesWhatExportWrote) {
  for (const Shapes& s : {two_kinds(), Shapes{}, Shapes{{measure_shape("one", tetrahedron(1))}}}) {
    const auto run = test::run_node("LoadShapes", {}, {{"path", test::exported_json(s)}});
    EXPECT_EQ(test::bytes_of(run.output<Shapes>("shapes")), test::bytes_of(s));
    EXPECT_EQ(run.metrics.at("shapes"), s.shapes.size());
  }
  const Shapes s = two_kinds();
  EXPECT_EQ(test::bytes_of(read_shapes("{\"table\":{},\"shapes\":" + text_of(s) + "}", "t.json")),
            test::bytes_of(s));
}

TEST(LoadShapes, WrongFieldsAreNamed) {
  const auto code = [](const std::string& from, const std::string& to) {
    const std::string text = test::replaced(text_of(two_kinds()), from, to);
    return test::code_of([&] { read_shapes(text, "t.json"); });
  };
  EXPECT_EQ(code("{", "["), "unreadable-file");
  EXPECT_EQ(code("\"shapes\"", "\"shape\""), "unreadable-file");
  EXPECT_EQ(code("\"mesh\"", "\"mash\""), "bad-shape");
  EXPECT_EQ(code("\"class\":-1", "\"class\":-2"), "bad-shape");
  EXPECT_EQ(code("\"probability\":0.9", "\"probability\":1.5"), "bad-shape");
  EXPECT_EQ(code("\"probability\":0.9", "\"probability\":0.8"), "bad-probabilities");
  EXPECT_EQ(code("\"volume\":", "\"volume\":-"), "bad-shape");
  EXPECT_EQ(code("\"smooth\":false", "\"smooth\":0"), "bad-shape");
  EXPECT_EQ(code("[0,2,1]", "[0,2,4]"), "bad-shape");
  EXPECT_EQ(code("[0,2,1]", "[0,2,-1]"), "bad-shape");
  EXPECT_EQ(code("[0,2,1]", "[0,2,1.5]"), "bad-shape");
  EXPECT_EQ(code("[0,2,1]", "[0,2]"), "bad-shape");
  EXPECT_EQ(code("[0,2,1],", ""), "open-mesh");
  EXPECT_EQ(code("[[0,2,1],[0,1,3],[0,3,2],[1,2,3]]", "[[0,1,2],[0,3,1],[0,2,3],[1,3,2]]"), "inside-out");
  EXPECT_EQ(code("\"uv\":[", "\"uv\":[[0,0,0,0,0,0],"), "bad-shape");
  EXPECT_EQ(code("\"color\":[", "\"color\":[[0,0,1e300],"), "bad-shape");
  EXPECT_EQ(code("\"color\":[", "\"color\":[[0,0,1],"), "bad-shape");
}

}  // namespace
}  // namespace terrazzo
