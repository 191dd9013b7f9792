#include "tests/nodes/photograph/load_ebsd/sample_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace terrazzo::test {
namespace {

using load_ebsd::LaueGroup;

// From 0 to 1, equal with every standard library.
double uniform(std::mt19937& g) { return g() / 4294967296.0; }

const char* tsl_symmetry(LaueGroup g) {
  static constexpr const char* codes[] = {"1", "20", "22", "4", "42", "3", "32", "6", "62", "23", "43"};
  return codes[static_cast<int>(g)];
}

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

Eigen::Quaternionf random_orientation(std::mt19937& g) {
  const double a = uniform(g), b = 2 * std::numbers::pi * uniform(g), c = 2 * std::numbers::pi * uniform(g);
  return Eigen::Quaterniond(std::sqrt(1 - a) * std::sin(b), std::sqrt(1 - a) * std::cos(b),
                            std::sqrt(a) * std::sin(c), std::sqrt(a) * std::cos(c))
      .cast<float>();
}

SampleMap sample_map(std::vector<load_ebsd::Symmetry> phases, unsigned seed, int cells, double noise,
                     double unindexed) {
  SampleMap m;
  m.phases = std::move(phases);
  std::mt19937 g(seed);
  struct Cell {
    std::array<double, 3> at;
    int phase;
    Eigen::Quaternionf orientation;
  };
  std::vector<Cell> all;
  for (int k = 0; k < cells; ++k) {
    Cell c{{uniform(g) * m.width, uniform(g) * m.height, (uniform(g) - 0.5) * 20},
           static_cast<int>(uniform(g) * static_cast<double>(m.phases.size())),
           random_orientation(g)};
    all.push_back(c);
  }
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      int best = 0;
      double least = 1e30;
      for (int k = 0; k < cells; ++k) {
        const auto& at = all[static_cast<std::size_t>(k)].at;
        const double d = std::pow(at[0] - x, 2) + std::pow(at[1] - y, 2) + at[2] * at[2];
        if (d < least) {
          least = d;
          best = k;
        }
      }
      const Cell& c = all[static_cast<std::size_t>(best)];
      const auto rotations = m.phases[static_cast<std::size_t>(c.phase)].rotations();
      const auto& any =
          rotations[static_cast<std::size_t>(uniform(g) * static_cast<double>(rotations.size()))];
      const Eigen::Vector3d axis(uniform(g) - 0.5, uniform(g) - 0.5, uniform(g) - 0.5);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(noise * uniform(g) * kDegree, axis.normalized()));
      m.cell.push_back(best);
      m.orientation.push_back(turn.cast<float>() * c.orientation * any);
      m.phase.push_back(uniform(g) < unindexed ? -1 : c.phase);
    }
  return m;
}

std::string as_ang(const SampleMap& m) {
  std::string out = "# TEM_PIXperUM          1.000000\n# x-star                0.5\n#\n";
  for (std::size_t k = m.phases.size(); k-- > 0;)
    out += fmt::format(
        "# Phase {}\n# MaterialName  \tPhase {}\n# Formula     \t\n# Info \t\t\n# Symmetry              {}\n"
        "# LatticeConstants      2.870 2.870 2.870  90.000  90.000  90.000\n# NumberFamilies        0\n",
        k + 1, k + 1, tsl_symmetry(m.phases[k].group));
  out += fmt::format(
      "#\n# GRID: SqrGrid\n# XSTEP: {0:.6f}\n# YSTEP: {0:.6f}\n# NCOLS_ODD: {1}\n# NCOLS_EVEN: {1}\n"
      "# NROWS: {2}\n#\n# OPERATOR: \tterrazzo\n#\n",
      m.step, m.width, m.height);
  for (std::size_t i = 0; i < m.cell.size(); ++i) {
    const Vec3 e = load_ebsd::to_bunge(m.orientation[i]) * kDegree;
    const double x = m.step * static_cast<double>(i % static_cast<std::size_t>(m.width));
    const double y = m.step * static_cast<double>(i / static_cast<std::size_t>(m.width));
    if (m.phase[i] < 0)
      out +=
          fmt::format("12.5664 12.5664 12.5664 {:.1f} {:.1f} 20 -1 {}\n", x, y, m.phases.size() > 1 ? 0 : 1);
    else
      out += fmt::format("{:.4f} {:.4f} {:.4f} {:.1f} {:.1f} {} 0.9 {}\n", e[0], e[1], e[2], x, y,
                         80 + m.cell[i] % 20, m.phase[i] + 1);
  }
  return out;
}

std::string as_ctf(const SampleMap& m, char point) {
  std::string out = fmt::format(
      "Channel Text File\r\nPrj\tsteel\r\nAuthor\t\r\nJobMode\tGrid\r\nXCells\t{0}\r\nYCells\t{1}\r\n"
      "XStep\t{2}\r\nYStep\t{2}\r\nAcqE1\t0\r\nAcqE2\t0\r\nAcqE3\t0\r\n"
      "Euler angles refer to Sample Coordinate system (CS0)!\tMag\t400\tCoverage\t100\r\nPhases\t{3}\r\n",
      m.width, m.height, m.step, m.phases.size());
  for (std::size_t k = 0; k < m.phases.size(); ++k)
    out += fmt::format("2.870;2.870;2.870\t90;90;90\tPhase {}\t{}\t229\t\t\tsome author [1] x\r\n", k + 1,
                       static_cast<int>(m.phases[k].group) + 1);
  out += "Phase\tX\tY\tBands\tError\tEuler1\tEuler2\tEuler3\tMAD\tBC\tBS\r\n";
  for (std::size_t i = 0; i < m.cell.size(); ++i) {
    const Vec3 e = m.phase[i] < 0 ? Vec3(0, 0, 0) : load_ebsd::to_bunge(m.orientation[i]);
    const double x = m.step * static_cast<double>(i % static_cast<std::size_t>(m.width));
    const double y = m.step * static_cast<double>(i / static_cast<std::size_t>(m.width));
    out += fmt::format("{}\t{:.4f}\t{:.4f}\t8\t0\t{:.3f}\t{:.3f}\t{:.3f}\t{:.4f}\t{}\t255\r\n",
                       m.phase[i] + 1, x, y, e[0], e[1], e[2], m.phase[i] < 0 ? 0.0 : 0.5,
                       m.phase[i] < 0 ? 20 : 80 + m.cell[i] % 20);
  }
  if (point != '.') {
    const auto data = out.find("XStep");
    std::replace(out.begin() + static_cast<std::ptrdiff_t>(data), out.end(), '.', point);
  }
  return out;
}

}  // namespace terrazzo::test
