#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/compare/compare/noise.h"
#include "runtime/random.h"

namespace terrazzo::compare {

namespace {

// Oklab channels of an image and of its four halves, and the mean with its variance estimated from blocks.
struct Pixels {
  std::array<std::vector<float>, 3> channel;
  std::array<std::array<std::vector<float>, 3>, 4> half;  // left, right, top, bottom
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  Vec3f linear = Vec3f::Zero();
};

constexpr int kBlocks = 6;  // per side

Pixels pixels_of(const Image& image, const char* which, const Work& work) {
  if (image.pixels.empty()) throw Error("no-pixels", fmt::format("image {} has no pixels", which));
  Pixels p;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  // About a million pixels suffice for a histogram.
  const std::size_t step = 1 + image.pixels.size() / 1000000;
  std::size_t index = 0;
  std::vector<Eigen::Vector3d> block_sum(static_cast<std::size_t>(kBlocks * kBlocks) * image.sections,
                                         Eigen::Vector3d::Zero());
  std::vector<double> block_count(block_sum.size(), 0.0);
  for (int s = 0; s < image.sections; ++s)
    for (int y = 0; y < image.height; ++y) {
      work.check();
      for (int x = 0; x < image.width; ++x) {
        const Vec3f& c = image.at(x, y, s);
        if (!c.allFinite())
          throw Error("bad-pixels", fmt::format("image {} has a non-finite pixel at ({}, {})", which, x, y));
        const Vec3f lab = linear_to_oklab(c);
        linear += c.cast<double>();
        p.mean += lab.cast<double>();
        const std::size_t block =
            (static_cast<std::size_t>(s) * kBlocks + y * kBlocks / image.height) * kBlocks +
            x * kBlocks / image.width;
        block_sum[block] += lab.cast<double>();
        ++block_count[block];
        if (mix64(index++) % step) continue;
        const bool sides[4] = {2 * x < image.width, 2 * x >= image.width, 2 * y < image.height,
                               2 * y >= image.height};
        for (int k = 0; k < 3; ++k) {
          p.channel[k].push_back(lab[k]);
          for (int h = 0; h < 4; ++h)
            if (sides[h]) p.half[h][k].push_back(lab[k]);
        }
      }
    }
  const double count = image.pixels.size();
  p.linear = (linear / count).cast<float>();
  p.mean /= count;
  double used = 0;
  for (std::size_t i = 0; i < block_sum.size(); ++i) {
    if (block_count[i] == 0) continue;
    const Eigen::Vector3d d = block_sum[i] / block_count[i] - p.mean;
    p.variance += d.cwiseProduct(d);
    ++used;
  }
  if (used > 1) p.variance /= used * (used - 1);
  return p;
}

double floor_of(const Pixels& p, int channel) {
  return std::max(earth_mover(p.half[0][channel], p.half[1][channel]),
                  earth_mover(p.half[2][channel], p.half[3][channel]));
}

}  // namespace

Comparison compare(const Image& a, const Image& b, const CompareOptions& choice, const Work& work) {
  const Pixels pa = pixels_of(a, "a", work), pb = pixels_of(b, "b", work);
  Comparison out;
  if (choice.color) {
    add_color(out, "image", pa.linear, pb.linear, pa.mean, pb.mean, pa.variance + pb.variance);
    const char* names[3] = {"L", "a", "b"};
    for (int k = 0; k < 3; ++k) {
      work.check();
      const double distance = earth_mover(pa.channel[k], pb.channel[k]);
      out.numbers.push_back({"color", fmt::format("histogram {}", names[k]), "Oklab", 0, 0, 0, distance,
                             std::max(floor_of(pa, k), floor_of(pb, k))});
      out.metrics[fmt::format("histogram_distance_{}", names[k])] = distance;
    }
  }
  compare_textures(a, b, choice, out, work.part(0.2, 1));
  return out;
}

}  // namespace terrazzo::compare
