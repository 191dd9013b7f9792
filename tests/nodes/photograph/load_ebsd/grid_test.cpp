// Where the points of a map are: their coordinates decide, and the header must agree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "graph/diagnostic.h"
#include "nodes/photograph/load_ebsd/grains.h"
#include "runtime/work.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_ebsd;

struct Point {
  double x, y;
  bool second;  // of two crystals
};

// A map of 12 × 8 points whose crystals meet at half of its width.
std::vector<Point> square(int columns = 12, int rows = 8, double x_step = 0.5, double y_step = 0.5) {
  std::vector<Point> out;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) out.push_back({c * x_step, r * y_step, 2 * c >= columns});
  return out;
}

// Rows of `columns` and `columns` - 1 points, or the other way around.
std::vector<Point> hexagonal(int columns, int rows, double step, bool first_shifted = false) {
  std::vector<Point> out;
  for (int r = 0; r < rows; ++r) {
    const bool shifted = (r % 2 == 1) != first_shifted;
    for (int c = 0; c < columns - shifted; ++c) {
      const double x = c + (shifted ? 0.5 : 0);
      out.push_back({x * step, r * step * std::sqrt(0.75), 2 * x >= columns});
    }
  }
  return out;
}

struct Format {
  std::string header =
      "# GRID: SqrGrid\n# XSTEP: 0.5\n# YSTEP: 0.5\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 12\n# NROWS: 8\n";
  int decimals = 5;
  std::string first_lines = "# Phase 1\n# MaterialName Ni\n# Symmetry 43\n";
};

std::string ang(const std::vector<Point>& points, const Format& f = {}) {
  std::string out = f.first_lines + f.header;
  for (const Point& p : points)
    out += fmt::format("{} 0 0 {:.{}f} {:.{}f} 100 0.9 1\n", p.second ? 0.5 : 0.0, p.x, f.decimals, p.y,
                       f.decimals);
  return out;
}

std::string ctf(const std::vector<Point>& points, const std::string& cells, const std::string& steps,
                char point = '.') {
  std::string out = "Channel Text File\nPrj\ttest\nJobMode\tGrid\n" + cells + steps +
                    "Phases\t1\n3.56;3.56;3.56\t90;90;90\tNi\t11\t225\n"
                    "Phase\tX\tY\tBands\tError\tEuler1\tEuler2\tEuler3\tMAD\tBC\tBS\n";
  for (const Point& p : points)
    out +=
        fmt::format("1\t{:.4f}\t{:.4f}\t8\t0\t{}\t0\t0\t0.5\t100\t200\n", p.x, p.y, p.second ? "28.6" : "0");
  if (point != '.') std::replace(out.begin() + 60, out.end(), '.', point);
  return out;
}

EbsdMap read(const std::string& text) {
  return text[0] == 'C' ? read_ctf(text, "a.ctf") : read_ang(text, "a.ang");
}

// The message of the error, without its file, or "".
std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    EXPECT_TRUE(e.diagnostic().code == "malformed-row" || e.diagnostic().code == "unreadable-file");
    return e.diagnostic().message;
  }
  return "";
}

// Expects two grains, the first to the left of column `border`.
void expect_halves(const EbsdMap& map, int width, int height, const std::string& what) {
  ASSERT_EQ(map.width, width) << what;
  ASSERT_EQ(map.height, height) << what;
  EXPECT_NEAR(map.pixel_size, 0.5, 1e-9) << what;
  const Grains g = find_grains(map, {}, Work());
  ASSERT_EQ(g.grains.size(), 2u) << what;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      EXPECT_EQ(g.labels.ids[static_cast<std::size_t>(y * width + x)], 2 * x < width ? 1 : 2) << what;
}

TEST(EbsdGrid, PointsMayBeInAnyOrder) {
  auto points = square();
  const auto both = [&](const std::string& what) {
    expect_halves(read(ang(points)), 12, 8, what);
    expect_halves(read(ctf(points, "XCells\t12\nYCells\t8\n", "XStep\t0.5\nYStep\t0.5\n")), 12, 8, what);
    expect_halves(read(ctf(points, "XCells\t12\nYCells\t8\n", "XStep\t0.5\nYStep\t0.5\n", ',')), 12, 8, what);
  };
  both("by rows");
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
  both("by columns");
  std::reverse(points.begin(), points.end());
  both("reversed");
  std::shuffle(points.begin(), points.end(), std::mt19937(1));
  both("shuffled");
}

TEST(EbsdGrid, MapsMayBeginAnywhere) {
  auto points = square();
  for (Point& p : points) {
    p.x += 4321.5;
    p.y -= 17.25;
  }
  expect_halves(read(ang(points)), 12, 8, "moved");
}

TEST(EbsdGrid, NegativeStepsDescend) {
  auto points = square();
  for (Point& p : points) p.x = -p.x, p.second = !p.second;  // x from 0 down
  Format f;
  f.header = "# GRID: SqrGrid\n# XSTEP: -0.5\n# YSTEP: 0.5\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 12\n# NROWS: 8\n";
  expect_halves(read(ang(points, f)), 12, 8, "descending");
  EXPECT_EQ(refusal(ang(square(), f)), "a.ang:11: x rises from 0 to 0.5 µm, but XSTEP is -0.5 µm");
}

// Programs write three to five decimals, of steps and of coordinates.
TEST(EbsdGrid, RoundedCoordinatesAreOnTheGrid) {
  for (const double step : {0.07, 0.125, 1.0 / 3, 2.345678})
    for (const int decimals : {2, 3, 4, 5}) {
      Format f;
      f.decimals = decimals;
      f.header = fmt::format(
          "# GRID: SqrGrid\n# XSTEP: {0:.{1}f}\n# YSTEP: {0:.{1}f}\n# NCOLS_ODD: 400\n# NCOLS_EVEN: 400\n"
          "# NROWS: 3\n",
          step, decimals + 1);
      const EbsdMap map = read(ang(square(400, 3, step, step), f));
      EXPECT_EQ(map.width, 400) << step << " " << decimals;
      EXPECT_NEAR(map.pixel_size / step, 1, 0.1 * std::pow(10.0, -decimals) / step + 1e-3);
      EXPECT_EQ(map.missing, 0);
    }
  // As short as the numbers are: "0", "0.5", "1".
  Format f;
  std::string text = f.first_lines + f.header;
  for (const Point& p : square())
    text += fmt::format("{} 0 0 {} {} 100 0.9 1\n", p.second ? 0.5 : 0.0, p.x, p.y);
  expect_halves(read(text), 12, 8, "shortest");
}

TEST(EbsdGrid, StepsThatContradictAreRefusedWithTheirLine) {
  const auto with_step = [](const char* step) {
    Format f;
    f.header = fmt::format(
        "# GRID: SqrGrid\n# XSTEP: {0}\n# YSTEP: {0}\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 12\n# NROWS: 8\n", step);
    return f;
  };
  // The points begin in line 10.
  EXPECT_EQ(refusal(ang(square(), with_step("2"))),
            "a.ang:11: x goes from 0 to 0.5 µm, and advances by 0.5 µm in the map, but XSTEP is 2 µm");
  EXPECT_EQ(refusal(ang(square(), with_step("0.125"))),
            "a.ang:11: x goes from 0 to 0.5 µm, and advances by 0.5 µm in the map, but XSTEP is 0.125 µm");
  EXPECT_EQ(refusal(ang(square(), with_step("0.55"))).substr(0, 9), "a.ang:11:");
  EXPECT_EQ(refusal(ang(square(), with_step("1"))),
            "a.ang:11: x is 0.5 µm, half a step of 1 µm (XSTEP) from the others");
  EXPECT_EQ(refusal(ang(square(), with_step("0.25"))).substr(0, 9), "a.ang:11:");
  EXPECT_EQ(refusal(ctf(square(), "XCells\t12\nYCells\t8\n", "XStep\t0.5\nYStep\t2\n")),
            "a.ctf:23: y goes from 0 to 0.5 µm, and advances by 0.5 µm in the map, but YStep is 2 µm");
  auto points = square();
  for (Point& p : points) p.x /= 1000, p.y /= 1000;  // in mm
  EXPECT_EQ(
      refusal(ang(points)),
      "a.ang:11: x goes from 0 to 0.0005 µm, and advances by 0.0005 µm in the map, but XSTEP is 0.5 µm");
  points = square();
  points[40].x += 0.2;  // in line 50
  EXPECT_EQ(refusal(ang(points)).substr(0, 9), "a.ang:50:") << refusal(ang(points));
}

TEST(EbsdGrid, CountsThatContradictAreRefused) {
  const auto with = [](int columns, int rows) {
    Format f;
    f.header = fmt::format(
        "# GRID: SqrGrid\n# XSTEP: 0.5\n# YSTEP: 0.5\n# NCOLS_ODD: {0}\n# NCOLS_EVEN: {0}\n# NROWS: {1}\n",
        columns, rows);
    return f;
  };
  EXPECT_EQ(refusal(ang(square(), with(11, 8))),
            "a.ang:21: x is 5.5 µm: column 12 of 11 (NCOLS_ODD and NCOLS_EVEN)");
  EXPECT_EQ(refusal(ang(square(), with(12, 7))).substr(0, 9), "a.ang:94:");
  EXPECT_EQ(refusal(ang(square(), with(8, 12))).substr(0, 9), "a.ang:18:");
  const std::string cropped = refusal(ang(square(), with(12, 9)));
  EXPECT_NE(
      cropped.find("12 columns and 8 rows, but its header has 12 (NCOLS_ODD and NCOLS_EVEN) and 9 (NROWS)"),
      std::string::npos)
      << cropped;
  EXPECT_NE(refusal(ctf(square(), "XCells\t13\nYCells\t8\n", "XStep\t0.5\nYStep\t0.5\n")).find("13 (XCells)"),
            std::string::npos);
}

TEST(EbsdGrid, MissingPointsAreNotIndexed) {
  auto points = square();
  points.erase(points.begin() + 50, points.begin() + 53);
  points.erase(points.begin() + 20);
  const EbsdMap map = read(ang(points));
  EXPECT_EQ(map.missing, 4);
  ASSERT_EQ(map.points.size(), 96u);
  for (const std::size_t i : {20u, 50u, 51u, 52u}) EXPECT_EQ(map.points[i].phase, -1) << i;
  EXPECT_EQ(std::count_if(map.points.begin(), map.points.end(), [](const auto& p) { return p.phase < 0; }),
            4);
  const auto file = test::temporary_folder() / "a.ang";
  std::ofstream(file) << ang(points);
  const auto run = test::run_node("LoadEBSD", {}, {{"path", file.string()}});
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("no point for 4 places"), std::string::npos) << run.warnings[0];
}

TEST(EbsdGrid, TwoPointsAtOnePlaceAreRefused) {
  auto points = square();
  points.push_back(points[13]);
  EXPECT_EQ(refusal(ang(points)), "a.ang:106: a second point at x 0.5 and y 0.5 µm; the first is in line 23");
  // A second map below the first.
  EXPECT_EQ(refusal(ang(square()) + "# GRID: SqrGrid\n" + "0 0 0 0 0 1 1 1\n").substr(0, 10), "a.ang:106:");
}

TEST(EbsdGrid, WithoutAGridInTheHeaderTheCoordinatesSuffice) {
  Format f;
  f.header = "";
  expect_halves(read(ang(square(), f)), 12, 8, "no grid");
  f.header = "# GRID: SqrGrid#\n";
  expect_halves(read(ang(square(), f)), 12, 8, "ASTAR");
}

const char* const kHexagonal =
    "# GRID: HexGrid\n# XSTEP: 0.577350\n# YSTEP: 0.500000\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 11\n# NROWS: 8\n";

// The share of pixels that are of the wrong crystal.
double wrong(const EbsdMap& map, double border, double left = 0) {
  double out = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const bool second = map.points[static_cast<std::size_t>(y * map.width + x)].orientation.w() < 0.999f;
      out += second != (left + (x + 0.5) * map.pixel_size > border);
    }
  return out / static_cast<double>(map.points.size());
}

TEST(EbsdGrid, HexagonalGridsAreRecognized) {
  const double step = 0.57735;
  auto points = hexagonal(12, 8, step);
  Format f;
  f.header = kHexagonal;
  const EbsdMap expected = read(ang(points, f));
  EXPECT_EQ(expected.height, 8);
  EXPECT_EQ(expected.width, 13);  // 11 steps of 0.577 µm in pixels of 0.5 µm
  EXPECT_LT(wrong(expected, 6 * step), 0.08);
  std::shuffle(points.begin(), points.end(), std::mt19937(2));
  const auto same = [&](const EbsdMap& map) {
    ASSERT_EQ(map.points.size(), expected.points.size());
    for (std::size_t i = 0; i < map.points.size(); ++i)
      EXPECT_TRUE(map.points[i].orientation.isApprox(expected.points[i].orientation, 1e-3f));
  };
  same(read(ang(points, f)));
  // .ctf has no word for hexagonal grids; programs give either number of columns, and either step.
  for (const char* cells : {"XCells\t12\nYCells\t8\n", "XCells\t11\nYCells\t8\n", "XCells\t23\nYCells\t8\n"})
    for (const char* steps : {"XStep\t0.5774\nYStep\t0.5000\n", "XStep\t0.2887\nYStep\t0.5\n"})
      same(read(ctf(points, cells, steps)));
  EXPECT_NE(refusal(ctf(points, "XCells\t10\nYCells\t8\n", "XStep\t0.5774\nYStep\t0.5\n")), "");
}

TEST(EbsdGrid, TheFirstRowOfAHexagonalGridMayBeTheShiftedOne) {
  Format f;
  f.header =
      "# GRID: HexGrid\n# XSTEP: 0.577350\n# YSTEP: 0.500000\n# NCOLS_ODD: 11\n# NCOLS_EVEN: 12\n# NROWS: "
      "8\n";
  const EbsdMap map = read(ang(hexagonal(12, 8, 0.57735, true), f));
  EXPECT_EQ(map.width, 13);
  EXPECT_LT(wrong(map, 6 * 0.57735), 0.08);
}

// Columns instead of rows are shifted.
TEST(EbsdGrid, HexagonalGridsMayBeTurned) {
  auto points = hexagonal(12, 8, 0.57735);
  for (Point& p : points) std::swap(p.x, p.y);
  const EbsdMap turned = read(ctf(points, "XCells\t8\nYCells\t12\n", "XStep\t0.5\nYStep\t0.5774\n"));
  Format f;
  f.header = kHexagonal;
  const EbsdMap expected = read(ang(hexagonal(12, 8, 0.57735), f));
  ASSERT_EQ(turned.width, expected.height);
  ASSERT_EQ(turned.height, expected.width);
  for (int y = 0; y < turned.height; ++y)
    for (int x = 0; x < turned.width; ++x)
      EXPECT_TRUE(turned.points[static_cast<std::size_t>(y * turned.width + x)].orientation.isApprox(
          expected.points[static_cast<std::size_t>(x * expected.width + y)].orientation, 1e-3f));
}

TEST(EbsdGrid, TheKindOfGridMustAgree) {
  Format f;
  f.header =
      "# GRID: SqrGrid\n# XSTEP: 0.57735\n# YSTEP: 0.5\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 11\n# NROWS: 8\n";
  const std::string refused = refusal(ang(hexagonal(12, 8, 0.57735), f));
  EXPECT_EQ(refused.substr(0, 19), "a.ang:22: x is 0.28");
  EXPECT_NE(refused.find("half a step from the points of the rows beside it, but GRID is SqrGrid"),
            std::string::npos);
  f.header = "# GRID: HexGrid\n# XSTEP: 0.5\n# YSTEP: 0.5\n# NCOLS_ODD: 12\n# NCOLS_EVEN: 12\n# NROWS: 8\n";
  EXPECT_EQ(
      refusal(ang(square(), f)),
      "a.ang:22: x is 0 µm, not half a step from the points of the rows beside it, but GRID is HexGrid");
}

TEST(EbsdGrid, RectangularStepsAreResampled) {
  Format f;
  f.header = "# GRID: SqrGrid\n# XSTEP: 1.0\n# YSTEP: 0.5\n# NCOLS_ODD: 6\n# NCOLS_EVEN: 6\n# NROWS: 8\n";
  auto points = square(6, 8, 1.0, 0.5);
  std::reverse(points.begin(), points.end());
  expect_halves(read(ang(points, f)), 12, 8, "rectangles");
}

TEST(EbsdGrid, PointsInTheWrongPlacesAreNoGrid) {
  std::mt19937 g(3);
  std::vector<Point> points;
  for (int i = 0; i < 200; ++i) points.push_back({g() % 100000 / 1e3, g() % 100000 / 1e3, false});
  EXPECT_NE(refusal(ang(points)), "");
  Format f;
  f.header = "";
  EXPECT_NE(refusal(ang(points, f)), "");
}

TEST(EbsdGrid, ReadsTheReportedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  std::vector<double> areas;
  for (const char* name : {"column_major.ang", "column_major.ctf", "oim8_header.ang"}) {
    const auto run = test::run_node("LoadEBSD", {}, {{"path", (data / "reports" / name).string()}});
    const auto& rows = run.output<Table>("table").rows;
    ASSERT_EQ(rows.size(), 4u) << name;
    std::vector<double> pixels;
    for (const auto& row : rows) pixels.push_back(std::get<double>(row[2]));
    EXPECT_EQ(pixels, (std::vector<double>{48, 144, 48, 144})) << name;
    EXPECT_TRUE(run.warnings.empty()) << run.warnings[0];
  }
}

}  // namespace
}  // namespace terrazzo
