#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <locale>

#include "nodes/cooccurrence/load_strokes/stroke_files.h"
#include "nodes/cooccurrence/load_strokes/svg_path.h"
#include "tests/support/code_of.h"
#include "tests/support/german_locale.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using namespace load_strokes;

fs::path file_of(const std::string& text, const char* extension) {
  static int number = 0;
  const fs::path file = test::temporary_folder() / ("s" + std::to_string(++number) + extension);
  std::ofstream(file) << text;
  return file;
}
Strokes svg(const std::string& body, const std::string& attributes = "width='100' height='50'") {
  return read_svg(
      file_of("<svg xmlns='http://www.w3.org/2000/svg' " + attributes + ">" + body + "</svg>", ".svg"));
}

TEST(SvgPath, CommandsAsWritten) {
  std::string broken;
  const auto lines = read_path("M1,2 l3 0 v4H1z m10 10 L20-5.5.5.25", 0.1, broken);
  EXPECT_EQ(broken, "");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], (std::vector<Vec2>{{1, 2}, {4, 2}, {4, 6}, {1, 6}, {1, 2}}));
  EXPECT_EQ(lines[1], (std::vector<Vec2>{{11, 12}, {20, -5.5}, {0.5, 0.25}}));
}

TEST(SvgPath, CurvesStayWithinTheTolerance) {
  std::string broken;
  for (const double tolerance : {1.0, 0.1, 0.001}) {
    // A half circle as an arc, and a cubic.
    const auto arc = read_path("M 10 0 A 10 10 0 0 1 -10 0", tolerance, broken)[0];
    for (std::size_t i = 0; i + 1 < arc.size(); ++i) {
      EXPECT_NEAR(arc[i].norm(), 10, 1e-9);
      EXPECT_GE(((arc[i] + arc[i + 1]) / 2).norm(), 10 - tolerance * 1.0001);
      EXPECT_GE(arc[i].y(), -1e-9);  // sweep 1 turns with increasing angle, y down
    }
    const auto cubic = read_path("M 0 0 C 0 50, 100 50, 100 0", tolerance, broken)[0];
    for (std::size_t i = 0; i < cubic.size(); ++i) {  // x = 100 (3t² − 2t³), y = 150 t (1 − t)
      const double t = static_cast<double>(i) / static_cast<double>(cubic.size() - 1);
      EXPECT_LT((cubic[i] - Vec2(100 * t * t * (3 - 2 * t), 150 * t * (1 - t))).norm(), 1e-9);
      if (i == 0) continue;
      const double m = t - 0.5 / static_cast<double>(cubic.size() - 1);
      EXPECT_LE(((cubic[i - 1] + cubic[i]) / 2 - Vec2(100 * m * m * (3 - 2 * m), 150 * m * (1 - m))).norm(),
                tolerance);
    }
  }
  // Smooth commands mirror the control point; a quadratic equals its cubic representation.
  const auto s = read_path("M0 0 C 0 10 10 10 10 0 S 20 -10 20 0", 0.01, broken)[0];
  EXPECT_EQ(s.back(), Vec2(20, 0));
  const auto q = read_path("M0 0 Q 10 20 20 0 T 40 0", 0.01, broken)[0];
  double lowest = 0, highest = 0;
  for (const auto& p : q) {
    lowest = std::min(lowest, p.y());
    highest = std::max(highest, p.y());
  }
  EXPECT_NEAR(highest, 10, 0.02);
  EXPECT_NEAR(lowest, -10, 0.02);
}

TEST(SvgPath, FlagsMayStandTogether) {
  std::string broken;
  const auto arc = read_path("M0 0a25,25 0 01 50,0", 0.1, broken);
  EXPECT_EQ(broken, "");
  EXPECT_EQ(arc[0].back(), Vec2(50, 0));
}

TEST(SvgPath, ErrorsAreTold) {
  for (const char* bad :
       {"L 1 2", "M 1", "M 1 2 C 1 2 3", "M 0 0 A 1 1 0 2 0 3 3", "M 0 0 X 1", "M 0 0 z 3", "5 5"}) {
    std::string broken;
    read_path(bad, 0.1, broken);
    EXPECT_NE(broken, "") << bad;
  }
}

TEST(LoadStrokes, SvgShapesStylesAndTransforms) {
  const Strokes s = svg(
      "<g stroke='red' stroke-width='4' fill='none' transform='translate(10 5) scale(2)'>"
      "<path d='M0 0 L10 0'/><polyline points='1,1 2,2 3,1'/></g>"
      "<circle cx='5' cy='5' r='2'/><rect x='1' y='2' width='3' height='4' style='fill:blue; stroke: none'/>"
      "<path d='M0 0 H9 V9 z M2 2 h3 v3 z'/><line x1='0' y1='0' x2='5' y2='5'/>"
      "<rect width='5' height='5' display='none'/><defs><rect width='5' height='5'/></defs><text>no</text>");
  ASSERT_EQ(s.strokes.size(), 5u);  // the line without a stroke has no area
  EXPECT_EQ(s.strokes[0].parts[0], (std::vector<Vec2>{{10, 5}, {30, 5}}));
  EXPECT_EQ(s.strokes[0].radius, 4);
  EXPECT_EQ(s.strokes[1].parts[0].size(), 3u);
  EXPECT_TRUE(s.strokes[2].area);
  for (const auto& p : s.strokes[2].parts[0]) EXPECT_NEAR((p - Vec2(5, 5)).norm(), 2, 1e-9);
  EXPECT_EQ(s.strokes[3].parts[0], (std::vector<Vec2>{{1, 2}, {4, 2}, {4, 6}, {1, 6}}));
  EXPECT_EQ(s.strokes[4].parts.size(), 2u);
}

TEST(LoadStrokes, SvgViewBox) {
  const Strokes s = svg("<line x1='0' y1='0' x2='10' y2='10' stroke='black'/>",
                        "width='100' height='50' viewBox='0 0 10 10'");
  EXPECT_LT((s.strokes[0].parts[0][0] - Vec2(25, 0)).norm(), 1e-9);
  EXPECT_LT((s.strokes[0].parts[0][1] - Vec2(75, 50)).norm(), 1e-9);
  EXPECT_NEAR(s.strokes[0].radius, 2.5, 1e-9);
}

TEST(LoadStrokes, YamlAndScale) {
  const fs::path file = file_of(
      "strokes:\n  - {radius: 2, points: [[1, 2], [3, 4]]}\n  - {area: true, points: [[0, 0], [4, 0], [4, "
      "4]]}\n"
      "  - \"3: 5 6\"\n",
      ".yaml");
  const Strokes s =
      test::run_node("LoadStrokes", {}, {{"path", file.string()}, {"scale", "2"}}).output<Strokes>("strokes");
  ASSERT_EQ(s.strokes.size(), 3u);
  EXPECT_EQ(s.strokes[0].radius, 4);
  EXPECT_EQ(s.strokes[0].parts[0][1], Vec2(6, 8));
  EXPECT_TRUE(s.strokes[1].area);
  EXPECT_EQ(s.strokes[2].parts[0][0], Vec2(10, 12));
}

const char* const kYaml = "strokes:\n  - {radius: 2.5, points: [[1.25, 2], [3, 1.250]]}\n  - \"3: 5 6\"\n";

TEST(LoadStrokes, LinesMayEndWithACarriageReturn) {
  for (const std::string end : {"\r", "\r\n"}) {
    std::string text;
    for (const char c : std::string(kYaml)) text += c == '\n' ? end : std::string(1, c);
    const Strokes s = read_yaml(file_of(text, ".yaml"));
    ASSERT_EQ(s.strokes.size(), 2u);
    EXPECT_EQ(s.strokes[0].parts[0][1], Vec2(3, 1.25));
  }
  const Strokes s = svg("<polyline\rpoints='1.5,2\r3,4'\rstroke='red'/>");
  EXPECT_EQ(s.strokes[0].parts[0], (std::vector<Vec2>{{1.5, 2}, {3, 4}}));
}

// "1.250" is 1250 where points group digits.
class GermanNumbers : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(LoadStrokes, TheLocaleOfTheProgramDoesNotMatter) {
  struct Changed {
    std::locale before = std::locale::global(std::locale(std::locale(), new GermanNumbers));
    ~Changed() { std::locale::global(before); }
  } changed;
  EXPECT_EQ(read_yaml(file_of(kYaml, ".yaml")).strokes[0].parts[0][1], Vec2(3, 1.25));
  const Strokes s = svg("<polyline points='1.250,2 3,4.5' stroke='red' transform='translate(0.5 1.5)'/>");
  EXPECT_EQ(s.strokes[0].parts[0], (std::vector<Vec2>{{1.75, 3.5}, {3.5, 6}}));
}

TEST(LoadStrokes, BadFilesAreRefused) {
  for (const char* bad : {"strokes: 5", "strokes:\n  - {radius: x, points: [[1, 2]]}",
                          "strokes:\n  - {radius: 2, points: [[1]]}", "strokes:\n  - {radius: 2}",
                          "strokes:\n  - {radius: 2, pionts: [[1, 2]]}", "a: [", "strokes:\n  - [1, 2]",
                          "strokes:\n  - {area: true, points: [[0, 0], [1, 1]]}",
                          "strokes:\n  - {radius: .nan, points: [[0, 0]]}"})
    EXPECT_EQ(test::code_of([&] { read_yaml(file_of(bad, ".yaml")); }), "bad-strokes-file") << bad;
  for (const char* bad : {"", "<svg", "<html/>", "<svg><path d='L 1 2' stroke='red'/></svg>",
                          "<svg><g transform='spin(3)'/></svg>"})
    EXPECT_EQ(test::code_of([&] { read_svg(file_of(bad, ".svg")); }), "bad-strokes-file") << bad;
  EXPECT_EQ(test::code_of([&] {
              test::run_node("LoadStrokes", {}, {{"path", file_of("x", ".txt").string()}});
            }),
            "unknown-format");
}

TEST(LoadStrokes, DoesNotDependOnTheLocale) {
  const auto all = [](const Strokes& s) { return test::bytes_of(s); };
  const std::string drawing =
      "<g transform='translate(0.5,1.5) rotate(12.5)'><polyline points='1.25,2.5 3.75-1234.5' stroke='red' "
      "stroke-width='1.5mm'/><line x1='0.5pt' y1='.25' x2='+1.5e1' y2='2.' stroke='red'/></g>";
  const auto yaml = file_of("strokes: [{radius: 1.5, points: [[0.25, 1234.5], [2.5, 1e-1]]}]\n", ".yaml");
  const auto drawn = all(svg(drawing, "width='10.5' height='7.5' viewBox='0.5 0.5 21 15'")),
             listed = all(read_yaml(yaml));
  EXPECT_EQ(read_yaml(yaml).strokes.at(0).parts.at(0).at(0), Vec2(0.25, 1234.5));
  const test::GermanLocale german;
  EXPECT_EQ(all(svg(drawing, "width='10.5' height='7.5' viewBox='0.5 0.5 21 15'")), drawn);
  EXPECT_EQ(all(read_yaml(yaml)), listed);
}

TEST(LoadStrokes, GivesWhatExportWroteToJson) {
  Strokes s;
  s.strokes.push_back({{{Vec2(0.1 + 0.2, 1e-300), Vec2(1.0 / 3, -0.0)}}, 1.0 / 7, false});
  s.strokes.push_back(
      {{{Vec2(0, 0), Vec2(9, 0), Vec2(9, 9)}, {Vec2(1, 1), Vec2(2, 1), Vec2(2, 2)}}, 2.5, true});
  s.strokes.push_back({{{Vec2(0, 0), Vec2(9, 0), Vec2(9, 9)}}, 0, true});
  const auto run = test::run_node("LoadStrokes", {}, {{"path", test::exported_json(s)}});
  EXPECT_EQ(test::bytes_of(run.output<Strokes>("strokes")), test::bytes_of(s));
}

}  // namespace
}  // namespace terrazzo
