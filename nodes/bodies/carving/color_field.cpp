#include "nodes/bodies/carving/color_field.h"

#include <openvdb/tools/Count.h>

#include <algorithm>
#include <cmath>

#include "nodes/bodies/carving/hidden_phases.h"
#include "nodes/common/geometry/grid/floor_of.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/volume.h"

namespace terrazzo::carving {
namespace {

constexpr float kUnit = 1.0f / (65535.0f * 65535.0f);
constexpr float kDarkest = 0.05f, kLightest = 0.9f;  // phases without colors
constexpr int kCover = 3;                            // voxels, as far as interpolation reaches

Error bad_color(std::size_t index, const Vec3i& n) {
  const std::size_t x = index % n.x(), y = index / n.x() % n.y(), z = index / n.x() / n.y();
  return Error("bad-colors", "the color of voxel (" + std::to_string(x) + ", " + std::to_string(y) + ", " +
                                 std::to_string(z) + ") is NaN or infinite");
}

std::size_t voxel_count(const Vec3i& n) {
  if (n.minCoeff() <= 0) throw Error("empty-volume", "the volume has no voxels");
  const double count = double(n.x()) * n.y() * n.z();
  if (count > 0x1p31)
    throw Error("too-large", "the volume has more than 2^31 voxels",
                "crop it or reduce its resolution first");
  return static_cast<std::size_t>(count);
}

}  // namespace

void ColorField::set(std::size_t index, const Vec3f& linear, std::size_t& outside) {
  if (!linear.allFinite()) throw bad_color(index, resolution_);
  if (linear.minCoeff() < -0.01f || linear.maxCoeff() > 1.01f) ++outside;
  for (int k = 0; k < 3; ++k)
    voxels_[index][k] = std::lround(65535.0f * std::sqrt(std::clamp(linear[k], 0.0f, 1.0f)));
}

ColorField::ColorField(Vec3i resolution, const std::vector<Vec3f>& colors, bool periodic)
    : resolution_(resolution), periodic_(periodic) {
  if (colors.size() != voxel_count(resolution))
    throw Error("bad-colors", "there are " + std::to_string(colors.size()) + " colors for " +
                                  std::to_string(voxel_count(resolution)) + " voxels");
  voxels_.resize(colors.size());
  std::size_t outside = 0;
  for (std::size_t i = 0; i < colors.size(); ++i) set(i, colors[i], outside);
  clamped_ = static_cast<float>(outside) / colors.size();
}

template <class Grid, class ColorOf>
void ColorField::copy(const Volume& volume, const Grid& grid, const Work& work, ColorOf&& color_of) {
  periodic_ = volume.periodic();
  voxel_ = grid.voxelSize().x();
  const openvdb::CoordBBox box = voxels_of(volume, grid);
  if (box.empty()) throw Error("empty-volume", "the grid '" + grid.getName() + "' has no active voxels");
  const openvdb::Coord first = box.min();
  const openvdb::Coord size = box.dim();
  resolution_ = Vec3i(size.x(), size.y(), size.z());
  const Vec3i n = resolution_;
  voxels_.resize(voxel_count(n));
  std::vector<std::size_t> outside(n.z());
  work.parallel(n.z(), 4, [&](std::size_t begin, std::size_t end) {
    auto voxels = grid.getConstAccessor();
    for (std::size_t z = begin; z < end; ++z) {
      work.check();
      std::size_t index = z * n.y() * n.x();
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x, ++index)
          set(index, color_of(voxels.getValue(first.offsetBy(x, y, static_cast<int>(z)))), outside[z]);
    }
  });
  std::size_t all = 0;
  for (const auto v : outside) all += v;
  clamped_ = static_cast<float>(all) / voxels_.size();
}

ColorField ColorField::of(const Volume& volume, const Work& work) {
  ColorField field;
  if (const auto grid = volume.find<openvdb::Vec3SGrid>("Cd")) {
    field.copy(volume, *grid, work, [](const openvdb::Vec3s& c) { return Vec3f(c.x(), c.y(), c.z()); });
    return field;
  }
  if (const auto phase = volume.find<openvdb::Int32Grid>("phase")) {
    const float last = std::max(1, openvdb::tools::minMax(phase->tree()).max());
    field.copy(volume, *phase, work, [&](std::int32_t p) {
      return Vec3f::Constant(kDarkest + (kLightest - kDarkest) * static_cast<float>(std::max(0, p)) / last);
    });
    return field;
  }
  std::string names;
  for (const auto& g : volume.grids)
    names += (names.empty() ? "" : ", ") + g->getName() + " (" + g->valueType() + ")";
  throw Error("no-color",
              "the volume has no color grid 'Cd' of three floats and no grid 'phase'; it has " +
                  (names.empty() ? std::string("no grids") : names),
              "connect a volume with colors, for example from Voxelize");
}

void ColorField::cover(const HiddenVoxels& hidden, const Work& work) {
  if (hidden.size != resolution_)
    throw Error("size-mismatch", "the grids 'Cd' and 'phase' have different voxels",
                "make both over the same voxels");
  std::vector<std::uint8_t> open = hidden.in;
  const Vec3i n = resolution_;
  for (int round = 0; round < kCover; ++round) {
    const std::vector<std::uint8_t> before = open;
    // Reads only voxels that were not open, and changes only those that were.
    work.quiet().parallel(n.z(), 4, [&](std::size_t begin, std::size_t end) {
      for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z)
        for (int y = 0; y < n.y(); ++y)
          for (int x = 0; x < n.x(); ++x)
            if (const std::size_t at = voxel_at(x, y, z, n); before[at] && cover_voxel(before, {x, y, z}))
              open[at] = 0;
    });
  }
}

bool ColorField::cover_voxel(const std::vector<std::uint8_t>& open, const Vec3i& at) {
  Vec3f sum = Vec3f::Zero();
  int found = 0;
  for (int k = 0; k < 27; ++k) {
    const int x = wrap(at.x() + k % 3 - 1, 0), y = wrap(at.y() + k / 3 % 3 - 1, 1),
              z = wrap(at.z() + k / 9 - 1, 2);
    if (open[voxel_at(x, y, z, resolution_)]) continue;
    sum += squared(x, y, z);
    ++found;
  }
  if (found == 0) return false;
  std::size_t outside = 0;
  set(voxel_at(at.x(), at.y(), at.z(), resolution_), sum * (kUnit / static_cast<float>(found)), outside);
  return true;
}

int ColorField::wrap(int i, int axis) const {
  const int n = resolution_[axis];
  return periodic_ ? wrap_index(i, n) : std::clamp(i, 0, n - 1);
}

Vec3f ColorField::at(const Vec3f& voxel) const {
  int at[3][2];
  float t[3];
  for (int k = 0; k < 3; ++k) {
    const float p = voxel[k] - 0.5f;
    const int low = floor_of(p);
    t[k] = p - low;
    at[k][0] = wrap(low, k);
    at[k][1] = wrap(low + 1, k);
  }
  Vec3f sum = Vec3f::Zero();
  float total = 0;  // 1, minus the skipped weights
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const float w = (x ? t[0] : 1 - t[0]) * (y ? t[1] : 1 - t[1]) * (z ? t[2] : 1 - t[2]);
    if (w < 1e-4f) continue;  // half of the corners, for a point on a face
    sum += w * squared(at[0][x], at[1][y], at[2][z]);
    total += w;
  }
  return sum * (kUnit / total);
}

Vec3f ColorField::sharp(const Vec3f& voxel) const {
  int at[3][4];
  float weight[3][4];
  for (int k = 0; k < 3; ++k) {
    const float p = voxel[k] - 0.5f;
    const int low = floor_of(p);
    const float t = p - low;
    for (int i = 0; i < 4; ++i) at[k][i] = wrap(low + i - 1, k);
    weight[k][0] = t * (-0.5f + t * (1 - 0.5f * t));
    weight[k][1] = 1 + t * t * (-2.5f + 1.5f * t);
    weight[k][2] = t * (0.5f + t * (2 - 1.5f * t));
    weight[k][3] = t * t * (-0.5f + 0.5f * t);
  }
  Vec3f sum = Vec3f::Zero();
  float total = 0;
  for (int z = 0; z < 4; ++z) {
    if (std::abs(weight[2][z]) < 1e-3f) continue;  // all but one, for a point on a face
    for (int y = 0; y < 4; ++y) {
      const float yz = weight[2][z] * weight[1][y];
      if (std::abs(yz) < 1e-3f) continue;
      for (int x = 0; x < 4; ++x)
        if (const float w = yz * weight[0][x]; std::abs(w) >= 1e-4f) {
          sum += w * squared(at[0][x], at[1][y], at[2][z]);
          total += w;
        }
    }
  }
  return (sum * (kUnit / total)).cwiseMax(0.0f).cwiseMin(1.0f);
}

bool has_voids(const Volume& volume) { return volume.find<openvdb::FloatGrid>("void") != nullptr; }

}  // namespace terrazzo::carving
