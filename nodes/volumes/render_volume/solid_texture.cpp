#include "nodes/volumes/render_volume/solid_texture.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/directions.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::render_volume {
namespace {

// Halves one axis of an x-fastest array: each texel is the mean of the texels it covers.
std::vector<Vec3f> halved(const std::vector<Vec3f>& in, Vec3i& size, int axis, const Work& work) {
  const int n = size[axis], m = std::max(1, n / 2);
  if (m == n) return in;
  const std::size_t stride = axis == 0   ? 1
                             : axis == 1 ? static_cast<std::size_t>(size.x())
                                         : pixels_in(size.x(), size.y());
  const std::size_t outer = in.size() / (stride * n);
  std::vector<Vec3f> out(outer * stride * m);
  const double ratio = static_cast<double>(n) / m;
  work.parallel(outer, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t o = begin; o < end; ++o)
      for (int j = 0; j < m; ++j) {
        const double from = j * ratio, to = (j + 1) * ratio;
        for (std::size_t s = 0; s < stride; ++s) {
          Vec3f sum = Vec3f::Zero();
          for (int i = from; i < n && i < to; ++i) {
            const double weight = std::min(to, i + 1.0) - std::max(from, double(i));
            sum += static_cast<float>(weight / ratio) * in[(o * n + i) * stride + s];
          }
          out[(o * m + j) * stride + s] = sum;
        }
      }
  });
  size[axis] = m;
  return out;
}

}  // namespace

SolidTexture::SolidTexture(const Vec3i& size, float texel_size, const std::vector<Vec3f>& colors,
                           const Work& work)
    : texel(texel_size) {
  if (size.minCoeff() < 1 || colors.size() != static_cast<std::size_t>(size.prod()))
    throw Error("empty-volume", "a texture has no voxels",
                "connect a solid texture, for example from SolidOptimize");
  std::vector<Vec3f> level = colors;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Vec3f& c : level) {
    if (!c.allFinite()) throw Error("bad-colors", "a texture contains NaN or infinity");
    c = c.cwiseMax(0.0f).cwiseMin(1.0f);
    sum += c.cast<double>();
  }
  mean = (sum / static_cast<double>(level.size())).cast<float>();
  Vec3i n = size;
  while (true) {
    work.check();
    Level l{n, {}};
    l.texels.resize(level.size());
    for (std::size_t i = 0; i < level.size(); ++i)
      for (int k = 0; k < 3; ++k) l.texels[i][k] = static_cast<std::uint16_t>(level[i][k] * 65535 + 0.5f);
    levels.push_back(std::move(l));
    if (n.maxCoeff() == 1) return;
    for (int axis = 0; axis < 3; ++axis) level = halved(level, n, axis, work);
  }
}

Placement placement(const SolidTexture& texture, double scale, double footprint, Turning turning,
                    std::uint64_t seed, std::uint64_t item) {
  Random random(seed, 0x54757262, item);
  Quat turn = Quat::Identity();
  const double angle = 2 * M_PI * random.uniform();
  const Quat any = random_quaternion(random);
  if (turning == Turning::AboutZ) turn = Eigen::AngleAxisd(angle, Vec3::UnitZ());
  if (turning == Turning::Random) turn = any.normalized();
  Placement p;
  const double texel = texture.texel * scale;  // mm, at level 0
  const double level = std::log2(std::max(footprint / texel, 1e-9));
  p.level = std::clamp(round_down(level + 0.5), 0, count_of(texture.levels) - 1);
  // Levels with odd sizes shrink by slightly more or less than two.
  const Vec3f ratio =
      texture.levels[p.level].size.cast<float>().cwiseQuotient(texture.levels[0].size.cast<float>());
  p.linear = ratio.asDiagonal() * (turn.toRotationMatrix() / texel).cast<float>();
  for (int k = 0; k < 3; ++k)
    p.offset[k] = static_cast<float>(random.uniform()) * float(texture.levels[p.level].size[k]);
  return p;
}

}  // namespace terrazzo::render_volume
