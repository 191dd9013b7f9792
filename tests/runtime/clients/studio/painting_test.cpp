#include "runtime/clients/studio/paint/painting.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/runtime/clients/studio/paint_picture.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using studio::NibOptions;
using studio::Painting;

NibOptions nib(std::vector<double> region) {
  NibOptions c;
  c.region = std::move(region);
  return c;
}

void stroke(Painting& p, double radius, const std::vector<Vec2>& points) {
  p.begin_stroke(radius);
  for (const auto& q : points) p.extend_stroke(q);
  p.end_stroke();
}

// Runs a graph and returns the content hash of its last image.
std::string replayed(const fs::path& graph) {
  const fs::path folder = test::temporary_folder(), report = folder / "report.json";
  const auto run = test::run_program({"run", graph.string(), "--no-cache", "--out", folder.string(),
                                      "--report", report.string(), "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::string content;
  const auto told = nlohmann::json::parse(std::ifstream(report));
  for (const auto& n : told.at("nodes"))
    if (n.at("outputs").contains("image")) content = n["outputs"]["image"]["content"];
  return content;
}

// The graph reproduces the image after several nibs, strokes that leave or miss the image, and undo.
TEST(Painting, TheGraphGivesTheSamePicture) {
  Painting p(test::paint_picture());
  const fs::path graph = test::temporary_folder() / "painted.yaml";
  p.choose(nib({2, 2, 40, 60}));
  stroke(p, 6.5, {{55, 35}, {60.25, 40}, {66, 44}});
  stroke(p, 6, {{200, 200}});  // misses
  stroke(p, 5, {{-20, 10}, {3, 12}, {20, 90}});
  NibOptions second = nib({2, 2, 40, 2, 40, 60, 2, 60});
  second.levels = 5;
  second.extent = 2;
  second.finish = "levels";
  second.threshold = 0.125;
  p.choose(second);
  stroke(p, 8, {{60, 40}});
  stroke(p, 3, {{10, 10}, {80, 70}});
  EXPECT_TRUE(p.undo());
  EXPECT_EQ(p.strokes(), 3u);
  std::ofstream(graph) << p.graph(graph);
  EXPECT_EQ(replayed(graph), p.content());
}

TEST(Painting, UndoGoesBackStepByStep) {
  Painting p(test::paint_picture());
  std::vector<std::string> contents = {p.content()};
  p.choose(nib({2, 2, 40, 60}));
  for (int k = 0; k < 3; ++k) {
    stroke(p, 5, {{20.0 + 20 * k, 20}, {30.0 + 20 * k, 40}});
    contents.push_back(p.content());
  }
  p.choose(nib({2, 10, 40, 60}));
  for (int k = 0; k < 2; ++k) {
    stroke(p, 5, {{20.0 + 20 * k, 50}});
    contents.push_back(p.content());
  }
  for (std::size_t k = contents.size() - 1; k > 3; --k) {
    EXPECT_EQ(p.content(), contents[k]);
    EXPECT_TRUE(p.undo());
  }
  EXPECT_TRUE(p.undo());  // the second nib
  for (std::size_t k = 3; k > 0; --k) {
    EXPECT_EQ(p.content(), contents[k]);
    EXPECT_TRUE(p.undo());
  }
  EXPECT_EQ(p.content(), contents[0]);
  EXPECT_TRUE(p.undo());  // the first nib
  EXPECT_FALSE(p.undo());
}

// A size that is rejected while a stroke is being painted leaves the stroke as it is.
TEST(Painting, ARejectedSizeChangesNothing) {
  const auto painted = [](double rejected) {
    Painting p(test::paint_picture());
    p.choose(nib({2, 2, 40, 60}));
    p.begin_stroke(5);
    p.extend_stroke({60, 30});
    if (rejected != 0) {
      EXPECT_ANY_THROW(p.begin_stroke(rejected));
    }
    p.extend_stroke({70, 36});
    p.end_stroke();
    EXPECT_EQ(p.strokes(), 1u);
    return p.content();
  };
  const std::string expected = painted(0);
  EXPECT_EQ(painted(200), expected);
  EXPECT_EQ(painted(-1), expected);
  EXPECT_EQ(painted(std::nan("")), expected);
}

TEST(Painting, RefusesBadInputAndStaysAsItWas) {
  Painting p(test::paint_picture());
  const auto code = [&](auto&& f) { return test::code_of(f); };
  EXPECT_EQ(code([&] { p.begin_stroke(5); }), "no-nib");
  EXPECT_EQ(code([&] { p.extend_stroke({5, 5}); }), "no-stroke");
  EXPECT_EQ(code([&] { p.choose(nib({0, 0, 3, 3})); }), "too-small");
  EXPECT_EQ(code([&] { p.choose(nib({0, 0, 300, 3})); }), "outside-image");
  EXPECT_EQ(code([&] { p.choose(nib({})); }), "bad-region");
  NibOptions bad = nib({2, 2, 40, 60});
  bad.levels = 1;
  EXPECT_EQ(code([&] { p.choose(bad); }), "bad-value");
  EXPECT_EQ(p.nib(), nullptr);
  p.choose(nib({2, 2, 40, 60}));
  const std::string before = p.content();
  EXPECT_EQ(code([&] { p.begin_stroke(-1); }), "bad-stroke");
  EXPECT_EQ(code([&] { p.begin_stroke(std::nan("")); }), "bad-stroke");
  EXPECT_EQ(code([&] { p.begin_stroke(200); }), "nib-too-large");
  p.begin_stroke(5);
  EXPECT_EQ(code([&] { p.extend_stroke({std::nan(""), 1}); }), "bad-stroke");
  p.end_stroke();
  EXPECT_EQ(p.content(), before);
  EXPECT_EQ(p.strokes(), 0u);
}

}  // namespace
}  // namespace terrazzo
