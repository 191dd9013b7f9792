#include "nodes/render_solid/color_field.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/volume.h"

namespace terrazzo {
namespace {

Error bad_color(std::size_t index, const Vec3i& n) {
  const std::size_t x = index % n.x(), y = index / n.x() % n.y(), z = index / n.x() / n.y();
  return Error("bad-colors", "the colour of voxel (" + std::to_string(x) + ", " + std::to_string(y) + ", " +
                                 std::to_string(z) + ") is no number");
}

std::size_t voxel_count(const Vec3i& n) {
  if (n.minCoeff() <= 0) throw Error("empty-volume", "the volume has no voxels to show");
  const double count = double(n.x()) * n.y() * n.z();
  if (count > 0x1p31) throw Error("too-large", "the volume has more than 2^31 voxels", "show a smaller part of it");
  return static_cast<std::size_t>(count);
}

}  // namespace

void ColorField::set(std::size_t index, const Vec3f& linear, std::size_t& outside) {
  if (!linear.allFinite()) throw bad_color(index, resolution_);
  if (linear.minCoeff() < -0.01f || linear.maxCoeff() > 1.01f) ++outside;
  for (int k = 0; k < 3; ++k)
    voxels_[index][k] =
        static_cast<std::uint16_t>(std::lround(65535.0f * std::sqrt(std::clamp(linear[k], 0.0f, 1.0f))));
}

ColorField::ColorField(Vec3i resolution, const std::vector<Vec3f>& colors, bool periodic)
    : resolution_(resolution), periodic_(periodic) {
  if (colors.size() != voxel_count(resolution))
    throw Error("bad-colors", "there are " + std::to_string(colors.size()) + " colours for " +
                                  std::to_string(voxel_count(resolution)) + " voxels");
  voxels_.resize(colors.size());
  std::size_t outside = 0;
  for (std::size_t i = 0; i < colors.size(); ++i) set(i, colors[i], outside);
  clamped_ = static_cast<float>(outside) / static_cast<float>(colors.size());
}

ColorField ColorField::of(const Volume& volume, const Work& work) {
  const auto grid = volume.find<openvdb::Vec3SGrid>("Cd");
  if (!grid) {
    std::string names;
    for (const auto& g : volume.grids) names += (names.empty() ? "" : ", ") + g->getName() + " (" + g->valueType() + ")";
    throw Error("no-color", "the volume has no colour grid 'Cd' of three floats; it has " +
                                (names.empty() ? std::string("no grids") : names),
                "connect a volume with colours, such as Voxelize's");
  }
  ColorField field;
  openvdb::Coord first(0);
  field.resolution_ = volume.resolution;
  field.periodic_ = volume.resolution.minCoeff() > 0;
  if (!field.periodic_) {
    const auto box = grid->evalActiveVoxelBoundingBox();
    if (box.empty()) throw Error("empty-volume", "the colour grid 'Cd' has no active voxels");
    first = box.min();
    const auto size = box.dim();
    field.resolution_ = Vec3i(size.x(), size.y(), size.z());
  }
  const Vec3i n = field.resolution_;
  field.voxels_.resize(voxel_count(n));
  std::vector<std::size_t> outside(static_cast<std::size_t>(n.z()));
  work.parallel(static_cast<std::size_t>(n.z()), 4, [&](std::size_t begin, std::size_t end) {
    auto voxels = grid->getConstAccessor();
    for (std::size_t z = begin; z < end; ++z) {
      work.check();
      std::size_t index = z * n.y() * n.x();
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x, ++index) {
          const auto& c = voxels.getValue(first.offsetBy(x, y, static_cast<int>(z)));
          field.set(index, Vec3f(c.x(), c.y(), c.z()), outside[z]);
        }
    }
  });
  std::size_t all = 0;
  for (const auto v : outside) all += v;
  field.clamped_ = static_cast<float>(all) / static_cast<float>(field.voxels_.size());
  return field;
}

int ColorField::wrap(int i, int axis) const {
  const int n = resolution_[axis];
  if (!periodic_) return std::clamp(i, 0, n - 1);
  i %= n;
  return i < 0 ? i + n : i;
}

Vec3f ColorField::at(const Vec3f& voxel) const {
  int low[3], high[3];
  float t[3];
  for (int k = 0; k < 3; ++k) {
    const float p = voxel[k] - 0.5f, floor = std::floor(p);
    t[k] = p - floor;
    low[k] = wrap(static_cast<int>(floor), k);
    high[k] = wrap(static_cast<int>(floor) + 1, k);
  }
  Vec3f sum = Vec3f::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const bool cx = corner & 1, cy = corner & 2, cz = corner & 4;
    const float w = (cx ? t[0] : 1 - t[0]) * (cy ? t[1] : 1 - t[1]) * (cz ? t[2] : 1 - t[2]);
    if (w < 1e-4f) continue;  // on a face, half of the corners
    const auto& v = voxels_[(static_cast<std::size_t>(cz ? high[2] : low[2]) * resolution_.y() + (cy ? high[1] : low[1])) *
                                resolution_.x() +
                            (cx ? high[0] : low[0])];
    const Vec3f root(v[0], v[1], v[2]);
    sum += w * root.cwiseProduct(root);
  }
  return sum * (1.0f / (65535.0f * 65535.0f));
}

}  // namespace terrazzo
