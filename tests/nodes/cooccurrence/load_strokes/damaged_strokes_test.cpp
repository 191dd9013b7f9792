// Drawings and lists of a few kilobytes that expand to gigabytes of points.
#include <gtest/gtest.h>

#include <fstream>

#include "nodes/cooccurrence/load_strokes/stroke_files.h"
#include "nodes/sizes/load_profiles/profile_table.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_profiles;
namespace fs = std::filesystem;

class DamagedStrokes : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  }
  static Reading budget(std::uint64_t bytes) {
    Reading r;
    r.memory = bytes;
    return r;
  }
  fs::path folder = test::temporary_folder();
};

std::string arcs(int count) {
  std::string d = "M0 0";
  for (int i = 0; i < count; ++i) d += "A99999 99999 0 1 1 9 " + std::to_string(i % 2);
  return "<svg><path stroke='red' d='" + d + "'/></svg>";
}

TEST_F(DamagedStrokes, ArcsByTheThousandStayWithinTheBudget) {
  EXPECT_EQ(test::code_of([&] { load_strokes::read_svg(write("a.svg", arcs(5)), budget(20'000'000)); }), "");
  EXPECT_EQ(test::code_of([&] { load_strokes::read_svg(write("a.svg", arcs(5000)), budget(20'000'000)); }),
            "too-large");
}

TEST_F(DamagedStrokes, PointsTooFarAwayForWholeNumbersOfChords) {
  for (const char* d : {"M0 0 C1e300 0 0 1e300 1 1", "M0 0 A1e300 1e-300 0 1 1 1 1",
                        "M1e308 0 Q-1e308 0 1e308 1e308", "M0 0 A1e308 1e308 1e308 1 0 1e308 0"})
    EXPECT_NE(test::code_of([&] {
                load_strokes::read_svg(
                    write("a.svg", std::string("<svg><path stroke='red' d='") + d + "'/></svg>"));
              }),
              "too-large")
        << d;
}

TEST_F(DamagedStrokes, AListThatIsNamedAndRepeatedStaysWithinTheBudget) {
  std::string text = "strokes:\n- &a {radius: 1, points: [";
  for (int i = 0; i < 1000; ++i) text += "[1,2],";
  text += "]}\n";
  for (int i = 0; i < 1000; ++i) text += "- *a\n";
  EXPECT_EQ(test::code_of([&] { load_strokes::read_yaml(write("a.yaml", text), budget(10'000'000)); }),
            "too-large");
  EXPECT_EQ(load_strokes::read_yaml(folder / "a.yaml", budget(200'000'000)).strokes.size(), 1001u);
}

TEST_F(DamagedStrokes, NestingIsBounded) {
  std::string groups = "<svg>", lists = "strokes: ";
  for (int i = 0; i < 100'000; ++i) groups += "<g>", lists += '[';
  EXPECT_EQ(test::code_of([&] { load_strokes::read_svg(write("a.svg", groups)); }), "bad-strokes-file");
  EXPECT_EQ(test::code_of([&] { load_strokes::read_yaml(write("a.yaml", lists)); }), "bad-strokes-file");
}

TEST_F(DamagedStrokes, TablesQuoteLittle) {
  try {
    read_profiles("area\n" + std::string(100'000, 'x') + "\n", "a.csv", profile_unit("mm"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_LT(e.diagnostic().message.size(), 400u);
  }
}

}  // namespace
}  // namespace terrazzo
