#include "nodes/solids/synthesis/exemplar/guide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace so = solids;

so::SolidExemplar half_plane(int n) {
  so::SolidExemplar e;
  e.width = n;
  e.height = n;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) e.pixels.push_back(Vec3f::Constant(x < n / 2 ? -1.0f : 0.7f));
  return e;
}

TEST(SolidGuide, IsTheDistanceToTheBorder) {
  std::vector<so::SolidExemplar> e{half_plane(64)};
  so::guide_by_phases(e, 2, 10);
  ASSERT_EQ(e[0].guide.size(), 64u * 64);
  const auto at = [&](int x) {
    return static_cast<double>(e[0].guide[static_cast<std::size_t>(20 * 64 + x)]);
  };
  const double step = at(33) - at(32);
  EXPECT_GT(step, 0);
  for (int x = 23; x < 41; ++x) EXPECT_NEAR(at(x + 1) - at(x), step, 1e-5) << x;
  for (int x : {5, 21}) EXPECT_EQ(at(x), at(0));
  for (int x : {45, 63}) EXPECT_EQ(at(x), at(50));
  double mean = 0, square = 0;
  for (const float g : e[0].guide) {
    mean += g / 4096.0;
    square += g * g / 4096.0;
  }
  EXPECT_NEAR(mean, 0, 1e-4);
  EXPECT_NEAR(square, 4, 1e-3);
}

TEST(SolidGuide, OnePhaseGuidesNowhere) {
  std::vector<so::SolidExemplar> e{half_plane(16)};
  for (auto& p : e[0].pixels) p = Vec3f::Zero();
  so::guide_by_phases(e, 1, 10);
  for (const float g : e[0].guide) EXPECT_EQ(g, 0);
}

TEST(SolidGuide, IsShrunkWithItsPicture) {
  std::vector<so::SolidExemplar> e{half_plane(32)};
  so::guide_by_phases(e, 1, 10);
  const auto levels = so::exemplar_levels(e[0], 1, 1, 2, 0.98, 32, 16, Work());
  ASSERT_EQ(levels[0].channels, 2);
  EXPECT_EQ(levels[1].channels, 1);  // beyond the requested levels
  const auto& g = e[0].guide;
  EXPECT_NEAR(levels[0].texels[4 * (3 * 16 + 7) + 1], (g[6 * 32 + 14] + g[6 * 32 + 15]) / 2, 1e-5);
}

// Connectedness of the dark parts: the diagonals of their pieces, weighted by pixels.
double reach(const Image& slices, float dark) {
  double sum = 0, count = 0;
  std::vector<std::uint8_t> seen(slices.pixels.size(), 0);
  for (int z = 0; z < slices.sections; ++z)
    for (int y = 0; y < slices.height; ++y)
      for (int x = 0; x < slices.width; ++x) {
        std::vector<Eigen::Vector2i> piece;
        const auto add = [&](int u, int v) {
          if (u < 0 || v < 0 || u >= slices.width || v >= slices.height) return;
          auto& done = seen[slices.index(u, v, z)];
          if (done || slices.at(u, v, z).mean() > dark) return;
          done = 1;
          piece.emplace_back(u, v);
        };
        add(x, y);
        Eigen::Vector2i low(x, y), high(x, y);
        for (std::size_t i = 0; i < piece.size(); ++i) {
          const Eigen::Vector2i at = piece[i];
          low = low.cwiseMin(at);
          high = high.cwiseMax(at);
          for (int v = -1; v <= 1; ++v)
            for (int u = -1; u <= 1; ++u) add(at.x() + u, at.y() + v);
        }
        const auto n = static_cast<double>(piece.size());
        sum += n * (high - low).cast<double>().norm();
        count += n;
      }
  return sum / count;
}

TEST(SolidGuide, VeinsHangTogether) {
  const Image exemplar =
      test::run_node("Pattern", {}, {{"kind", "marble"}, {"width", "96"}, {"height", "96"}})
          .output<Image>("image");
  float least = 1, most = 0;
  for (const auto& p : exemplar.pixels) {
    least = std::min(least, p.mean());
    most = std::max(most, p.mean());
  }
  const float dark = least + 0.65f * (most - least);
  const double wanted = reach(exemplar, dark);
  double got[2] = {};
  for (int guided = 0; guided < 2; ++guided)
    for (const char* seed : {"1", "2"}) {
      const auto r =
          test::run_node("SolidOptimize", {{"exemplar", Value::of<Image>(exemplar)}},
                         {{"size", "64"}, {"guide", guided ? "1" : "0"}, {"copying", "0"}, {"seed", seed}});
      const auto& grid = *r.output<Volume>("volume").find<openvdb::Vec3SGrid>("Cd");
      const auto read = grid.getConstAccessor();
      Image slices(64, 64, 8, 0.1);
      for (int z = 0; z < 8; ++z)
        for (int y = 0; y < 64; ++y)
          for (int x = 0; x < 64; ++x) {
            const auto c = read.getValue({8 * z, x, y});
            slices.at(x, y, z) = Vec3f(c[0], c[1], c[2]);
          }
      got[guided] += reach(slices, dark) / 2;
    }
  EXPECT_GT(got[1], 1.15 * got[0]);
  EXPECT_LT(got[1], wanted);
}

}  // namespace
}  // namespace terrazzo
