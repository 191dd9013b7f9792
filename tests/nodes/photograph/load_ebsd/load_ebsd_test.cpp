#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "nodes/data/profiles.h"
#include "nodes/photograph/load_ebsd/grains.h"
#include "runtime/work.h"
#include "tests/nodes/photograph/load_ebsd/sample_map.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"
#include "tests/support/replaced.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using test::replaced;
using namespace load_ebsd;
using enum LaueGroup;

std::string saved(const std::string& name, const std::string& text) {
  const auto file = test::temporary_folder() / name;
  std::ofstream(file, std::ios::binary) << text;
  return file.string();
}

// The connected parts of the cells, as find_grains() numbers them.
std::vector<std::int32_t> true_grains(const test::SampleMap& m) {
  std::vector<std::int32_t> ids(m.cell.size(), 0);
  std::int32_t last = 0;
  for (std::size_t start = 0; start < ids.size(); ++start) {
    if (ids[start] != 0 || m.phase[start] < 0) continue;
    std::vector<std::size_t> open{start};
    ids[start] = ++last;
    while (!open.empty()) {
      const std::size_t i = open.back(), w = static_cast<std::size_t>(m.width);
      open.pop_back();
      const auto visit = [&](std::size_t n) {
        if (ids[n] == 0 && m.phase[n] >= 0 && m.cell[n] == m.cell[i]) {
          ids[n] = last;
          open.push_back(n);
        }
      };
      if (i % w > 0) visit(i - 1);
      if (i % w + 1 < w) visit(i + 1);
      if (i >= w) visit(i - w);
      if (i + w < ids.size()) visit(i + w);
    }
  }
  return ids;
}

TEST(LoadEBSD, FindsTheGrainsOfEverySymmetry) {
  for (int k = 0; k < 11; ++k) {
    const auto m =
        test::sample_map({{static_cast<LaueGroup>(k)}, {CubicHigh}}, 10 + static_cast<unsigned>(k));
    GrainRule rule;
    rule.misorientation = 3;  // adjacent cells seldom differ by less
    for (const auto& text : {test::as_ang(m), test::as_ctf(m), test::as_ctf(m, ',')}) {
      const EbsdMap map = text[0] == 'C' ? read_ctf(text, "a.ctf") : read_ang(text, "a.ang");
      EXPECT_EQ(map.phases[0].symmetry.group, static_cast<LaueGroup>(k));
      EXPECT_EQ(map.phases[0].name, "Phase 1");
      const Grains g = find_grains(map, rule, Work());
      EXPECT_EQ(g.labels.ids, true_grains(m)) << name_of(map.phases[0].symmetry.group);
      EXPECT_EQ(g.labels.pixel_size, 0.0005);
      for (std::size_t i = 0; i < m.cell.size(); ++i)
        if (g.labels.ids[i] > 0) {
          const Grain& grain = g.grains[static_cast<std::size_t>(g.labels.ids[i] - 1)];
          EXPECT_EQ(grain.phase, m.phase[i]);
          EXPECT_GT(half_angle_cosine(grain.mean, m.orientation[i],
                                      m.phases[static_cast<std::size_t>(grain.phase)].rotations()),
                    std::cos(0.6 * 3.14159 / 180 / 2 * 2));  // 0.5 degrees of noise, and rounding
          EXPECT_LT(grain.spread, 0.6);
          EXPECT_NEAR(grain.quality, 80 + m.cell[i] % 20, 1e-3);
        }
    }
  }
}

TEST(LoadEBSD, TheSampleIsThatOfTheTests) {
  const auto m = test::sample_map({{CubicHigh}, {CubicHigh}}, 1);
  std::ifstream in(test::source_folder() / "nodes/photograph/load_ebsd/steel.ang", std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const EbsdMap map =
      read_ang(text, "steel.ang");  // compared by its grains, since libraries round differently
  EXPECT_EQ(map.width, m.width);
  GrainRule rule;
  rule.misorientation = 3;
  EXPECT_EQ(find_grains(map, rule, Work()).labels.ids, true_grains(m));
}

TEST(LoadEBSD, SettingsSelectPoints) {
  const auto m = test::sample_map({{CubicHigh}, {HexagonalHigh}}, 3);
  const std::string file = saved("a.ang", test::as_ang(m));
  const auto run = [&](std::map<std::string, std::string> p) {
    p["path"] = file;
    return test::run_node("LoadEBSD", {}, p);
  };
  const auto all = run({});
  const auto& labels = all.output<Labels>("labels");
  EXPECT_EQ(all.output<Table>("table").rows.size(), static_cast<std::size_t>(labels.count()));
  EXPECT_EQ(all.output<Image>("image").pixels.size(), labels.ids.size());
  EXPECT_NEAR(all.metrics.at("indexed"), 0.98, 0.01);
  const auto one = run({{"phases", "[2]"}});
  for (std::size_t i = 0; i < m.phase.size(); ++i)
    EXPECT_EQ(one.output<Labels>("labels").ids[i] > 0, m.phase[i] == 1);
  EXPECT_EQ(test::code_of([&] { run({{"phases", "[3]"}}); }), "bad-value");
  EXPECT_EQ(test::code_of([&] { run({{"min_confidence", "0.95"}}); }), "no-particles");
  EXPECT_EQ(run({{"fill", "5"}}).metrics.at("area_fraction"), 1);
  const auto large = run({{"min_pixels", "20"}});
  EXPECT_LT(large.metrics.at("grains"), all.metrics.at("grains"));
  for (const auto& row : large.output<Table>("table").rows) EXPECT_GE(std::get<double>(row[2]), 20);
  const auto gray = run({{"picture", "quality"}});
  for (const auto& p : gray.output<Image>("image").pixels) EXPECT_EQ(p.x(), p.z());
  // One grain per phase if everything is joined.
  EXPECT_LT(run({{"misorientation", "60"}}).metrics.at("grains"), all.metrics.at("grains") / 2);
  // Segment measures the grains in mm².
  const auto filled = run({{"fill", "5"}});
  const auto segment = test::run_node(
      "Segment", {{"image", filled.outputs.at("image")}, {"labels", filled.outputs.at("labels")}});
  const auto& profiles = segment.output<Profiles>("profiles");
  EXPECT_EQ(profiles.profiles.size(), filled.output<Table>("table").rows.size());
  double area = 0;
  for (const auto& p : profiles.profiles) area += p.area;
  EXPECT_NEAR(area, 64 * 56 * 0.0005 * 0.0005, 0.02 * 64 * 56 * 0.0005 * 0.0005);
}

std::string hexagonal(int odd, int even, int rows) {
  std::string out = fmt::format(
      "# Phase 1\n# MaterialName X\n# Symmetry 43\n# GRID: HexGrid\n# XSTEP: 1.0\n# YSTEP: 0.8660254\n"
      "# NCOLS_ODD: {}\n# NCOLS_EVEN: {}\n# NROWS: {}\n",
      odd, even, rows);
  // Two crystals: the border is vertical at half of the width.
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < (r % 2 ? even : odd); ++c) {
      const double x = c + (r % 2 ? 0.5 : 0);
      out += fmt::format("{} 0 0 {:.3f} {:.3f} 1 1 0\n", x < odd / 2.0 ? 0.0 : 0.5, x, r * 0.8660254);
    }
  return out;
}

// As files and in other encodings.
TEST(LoadEBSD, EncodingsAndLineEndsDoNotMatter) {
  const auto m = test::sample_map({{CubicHigh}}, 3, 5);
  const auto grains = [](const std::string& bytes) {
    const auto run = test::run_node("LoadEBSD", {}, {{"path", saved("a", bytes)}});
    return run.output<Labels>("labels").ids;
  };
  for (const std::string& text : {test::as_ang(m), test::as_ctf(m)}) {
    const auto expected = grains(text);
    std::string wide = "\xff\xfe", carriage = text;
    for (const char c : text) wide += {c, '\0'};
    std::erase(carriage, '\n' == text[text.find_first_of("\r\n")] ? '\r' : '\n');
    std::replace(carriage.begin(), carriage.end(), '\n', '\r');
    EXPECT_EQ(grains("\xef\xbb\xbf" + text), expected);
    EXPECT_EQ(grains(wide), expected);
    EXPECT_EQ(grains(carriage), expected);
  }
}

TEST(LoadEBSD, HexagonalGridsBecomePixels) {
  const EbsdMap map = read_ang(hexagonal(21, 20, 30), "h.ang");
  EXPECT_EQ(map.height, 30);
  EXPECT_EQ(map.width, 23);  // 20 µm in pixels of 0.866 µm
  const Grains g = find_grains(map, {}, Work());
  ASSERT_EQ(g.grains.size(), 2u);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const double at = (x + 0.5) * 0.8660254;  // µm, and the border is at 10.5 ± one point
      if (std::abs(at - 10.75) <= 0.9) continue;
      EXPECT_EQ(g.labels.ids[static_cast<std::size_t>(y * map.width + x)], at < 10.75 ? 1 : 2) << x;
    }
}

TEST(LoadEBSD, DamagedFilesAreErrors) {
  auto m = test::sample_map({{CubicHigh}, {HexagonalHigh}}, 3, 5);
  const std::string ang = test::as_ang(m), ctf = test::as_ctf(m);
  const auto code = [](const std::string& text) {
    const std::string file = saved("bad", text);
    return test::code_of([&] { test::run_node("LoadEBSD", {}, {{"path", file}}); });
  };
  EXPECT_EQ(code(ang), "");
  EXPECT_EQ(code(ctf), "");
  const std::string row = " 0.0 0.0 8";  // of the first point
  for (const auto& text :
       {std::string(), std::string("# nothing\n"), std::string("1 2 3 0 0 1 1 1\n"),
        replaced(ang, "NROWS: 56", "NROWS: 57"), replaced(ang, "NROWS: 56", "NROWS: 0"),
        replaced(ang, "XSTEP: 0.5", "XSTEP: 0.0"), replaced(ang, "NCOLS_ODD: 64", "NCOLS_ODD: 999999999"),
        replaced(ang, "Symmetry              62", "Symmetry 99"), replaced(ang, "# Phase 2", "# Phase 0"),
        ang.substr(0, ang.size() / 2 / 10 * 10 + ang.substr(ang.size() / 2 / 10 * 10).find('\n') + 1),
        replaced(ctf, "Grid", "Interactive"), replaced(ctf, "Euler2", "Eule2"),
        replaced(ctf, "Phase\tX", "Phse\tX"), replaced(ctf, "Phase\tX", "Phase\tx"),
        replaced(ctf, "YCells\t56", "YCells\t60"), ctf.substr(0, ctf.find("Phases"))})
    EXPECT_EQ(code(text), "unreadable-file") << text.substr(0, 400);
  for (const auto& text :
       {replaced(ang, row, " 0.0 nan 8"), replaced(ang, row, " 0.0 x 8"), replaced(ang, row, " 0.0"),
        replaced(ang, "\n12.5664", "\n90"), replaced(ang, " 0.9 1\n", " 0.9 7\n"),
        replaced(ang, " 0.9 1\n", " 0.9 1.5\n"), ang + "0 0 0 0 0 1 1 1\n",
        replaced(ang, "XSTEP: 0.5", "XSTEP: -0.5"), replaced(ang, "YSTEP: 0.5", "YSTEP: 70.5"),
        replaced(ang, "GRID: SqrGrid", "GRID: Cubic"), replaced(ang, "NROWS: 56", "NROWS: -1"),
        replaced(ctf, "XCells\t64", "XCells\tmany"), replaced(ctf, "Phases\t2", "Phases\t0"),
        replaced(ctf, "Phases\t2", "Phases\t3"), replaced(ctf, "Phase 1\t11", "Phase 1\t12"),
        replaced(ctf, "\r\n1\t", "\r\n9\t"), replaced(ctf, "\r\n1\t", "\r\n1e400\t"),
        ctf + ctf.substr(ctf.rfind("\n", ctf.size() - 3) + 1)})
    EXPECT_EQ(code(text), "malformed-row") << text.substr(0, 400);
  // Files of one phase number it 0.
  const auto single = test::sample_map({{CubicHigh}}, 3, 5);
  std::string zero = test::as_ang(single);
  for (auto at = zero.find(" 0.9 1\n"); at != std::string::npos; at = zero.find(" 0.9 1\n"))
    zero[at + 5] = '0';
  EXPECT_EQ(code(zero), "");
}

TEST(LoadEBSD, RandomDamageIsAnErrorOrAMap) {
  auto m = test::sample_map({{CubicHigh}, {HexagonalHigh}}, 3, 5);
  std::mt19937 g(1);
  for (const std::string& good : {test::as_ang(m), test::as_ctf(m)}) {
    int maps = 0, errors = 0;
    for (int k = 0; k < 300; ++k) {
      std::string text = good;
      for (unsigned n = g() % 4 + 1; n > 0; --n) {
        const std::size_t at = g() % (k % 2 ? text.size() : 900);
        switch (g() % 3) {
          case 0:
            text[at] = static_cast<char>(g());
            break;
          case 1:
            text.erase(at, g() % 40);
            break;
          default:
            text.insert(at, text.substr(g() % text.size(), g() % 40));
        }
      }
      try {
        const EbsdMap map = good[0] == 'C' ? read_ctf(text, "x") : read_ang(text, "x");
        EXPECT_EQ(map.points.size(), static_cast<std::size_t>(map.width) * map.height);
        ++maps;
      } catch (const Error&) {
        ++errors;
      }
    }
    EXPECT_GT(maps, 5);
    EXPECT_GT(errors, 5);
  }
}

}  // namespace
}  // namespace terrazzo
