// Names from strangers' files in the text formats that Export writes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "nodes/data/table.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/mesh_file.h"
#include "nodes/export/formats/usda_file.h"
#include "runtime/json_text.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;

const std::string kName = "a\nv 9 9 9\rf 1 2 3\x1b[2K\u202e\u009b\" # <b>";

bool steers(const std::string& text) {
  return text.find_first_of("\x1b\r\x7f") != std::string::npos || text.find("\u202e") != std::string::npos ||
         text.find("\u009b") != std::string::npos;
}

Shapes named() {
  Shapes out;
  out.shapes = {test::tetrahedron(kName, true)};
  return out;
}

TEST(ForeignNames, WriteNoStatementsIntoMeshes) {
  const auto file = test::temporary_folder() / "a.obj";
  write_mesh(file, named());
  const std::string text = test::content_of(file);
  EXPECT_FALSE(steers(text)) << text;
  std::istringstream lines(text);
  int vertices = 0, faces = 0;
  for (std::string line; std::getline(lines, line);)
    vertices += line.starts_with("v "), faces += line.starts_with("f ");
  EXPECT_EQ(vertices, 4) << text;
  EXPECT_EQ(faces, 4) << text;
  EXPECT_NE(text.find("o a v 9 9 9 f 1 2 3\\u001b[2K"), std::string::npos) << text;
}

TEST(ForeignNames, StayInTheirQuotes) {
  const auto file = test::temporary_folder() / "a.usda";
  write_usda(file, named(), {}, R"({"name": "x\u202e"})");
  const std::string usda = test::content_of(file);
  EXPECT_FALSE(steers(usda)) << usda;
  EXPECT_NE(usda.find(R"(string name = "a\nv 9 9 9\\u000df 1 2 3\\u001b[2K)"), std::string::npos) << usda;

  Table table;
  table.columns = {"a\x1b,b"};
  table.rows = {{kName}, {std::string("two\nlines")}};
  const std::string csv = csv_of(table);
  EXPECT_FALSE(steers(csv)) << csv;
  EXPECT_NE(csv.find("\"two\nlines\""), std::string::npos) << csv;  // a cell may have lines
  EXPECT_FALSE(steers(csv_of(named())));

  const std::string json = json_text({{"name", kName}});
  EXPECT_FALSE(steers(json)) << json;
  EXPECT_EQ(nlohmann::json::parse(json).at("name").get<std::string>(), kName);
}

}  // namespace
}  // namespace terrazzo
