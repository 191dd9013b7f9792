// Volumes as the page draws them: slices, and reduced blocks of voxels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/volume.h"
#include "runtime/clients/studio/views/geometry_views.h"
#include "runtime/clients/studio/views/view_bytes.h"

namespace terrazzo::studio {
using nlohmann::json;
namespace {

const openvdb::GridBase& grid_of(const Volume& volume, const std::string& name) {
  for (const auto& g : volume.grids)
    if (g->getName() == name || name.empty()) return *g;
  throw Error("no-such-grid", fmt::format("the volume has no grid '{}' (its grids: {})", name,
                                          fmt::join(grid_names(volume), ", ")));
}

// Calls f with a function that gives the color of a voxel, and true if the grid's numbers are a quantity.
template <class F>
void with_colors(const openvdb::GridBase& grid, double lo, double hi, F&& f) {
  const double scale = hi > lo ? 255 / (hi - lo) : 0;
  const auto gray = [=](double v) {
    const double g = std::isfinite(v) ? std::clamp((v - lo) * scale, 0.0, 255.0) : 0;
    return 0xff000000u | static_cast<std::uint32_t>(std::lround(g)) * 0x010101u;
  };
  const auto offer = [&]<class Grid>(const Grid*, auto&& color, bool quantity) {
    const auto* g = dynamic_cast<const Grid*>(&grid);
    if (g)
      f([at = g->getConstAccessor(), color](const openvdb::Coord& c) { return color(at.getValue(c)); },
        quantity);
    return g != nullptr;
  };
  using namespace openvdb;
  const auto number = [&](auto v) { return gray(static_cast<double>(v)); };
  const bool known =
      offer(static_cast<const FloatGrid*>(nullptr), number, true) ||
      offer(
          static_cast<const Vec3SGrid*>(nullptr),
          [](const Vec3s& v) { return rgba(Vec3f(v[0], v[1], v[2])); }, false) ||
      offer(
          static_cast<const Int32Grid*>(nullptr), [](std::int32_t v) { return color_of(v < 0 ? 0 : v + 1); },
          false) ||
      offer(static_cast<const DoubleGrid*>(nullptr), number, true) ||
      offer(
          static_cast<const BoolGrid*>(nullptr), [](bool v) { return v ? 0xffffffffu : 0xff000000u; },
          false) ||
      offer(
          static_cast<const Vec3IGrid*>(nullptr),
          [](const openvdb::Vec3i& v) { return color_of(1 + v[0] % 251 + 251 * (v[1] % 251)); }, false);
  if (!known)
    throw Error("unsupported-grid", fmt::format("grid '{}' has the type {}", grid.getName(), grid.type()));
}

// The share of a voxel that is material, by the grid that Voxelize makes of it.
std::shared_ptr<const openvdb::FloatGrid> coverage(const Volume& volume) {
  const auto g = volume.find<openvdb::FloatGrid>("density");
  return g && volume.find<openvdb::Vec3SGrid>("Cd") ? g : nullptr;
}

// The number of voxels in a box that are inactive and have each value other than the background: inside of
// a level set, for example.
template <class Grid>
std::map<double, double> inactive_values(const Grid& grid, const VoxelBox& box) {
  const Eigen::Vector3i last = box.first + box.size - Eigen::Vector3i::Ones();
  const openvdb::CoordBBox all({box.first.x(), box.first.y(), box.first.z()}, {last.x(), last.y(), last.z()});
  std::map<double, double> out;
  for (auto it = grid.cbeginValueOff(); it; ++it) {
    if (*it == grid.background() || !std::isfinite(*it)) continue;
    openvdb::CoordBBox part;
    it.getBoundingBox(part);
    part.intersect(all);
    if (!part.empty()) out[static_cast<double>(*it)] += static_cast<double>(part.volume());
  }
  return out;
}

// The range of a grid's numbers in a box, the range without the outermost hundredth of them, and the number
// below which four fifths of them are.
template <class Grid>
void add_ranges(json& out, const Grid& grid, const VoxelBox& box) {
  constexpr int kBins = 4096;
  const double background = static_cast<double>(grid.background());
  double lo = background, hi = background;
  for (auto it = grid.cbeginValueOn(); it; ++it)
    if (const double v = *it; std::isfinite(v)) {
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
  const auto inactive = inactive_values(grid, box);
  if (!inactive.empty()) {
    lo = std::min(lo, inactive.begin()->first);
    hi = std::max(hi, inactive.rbegin()->first);
  }
  std::vector<double> counts(kBins);
  double total = 0;
  const auto add = [&](double v, double n) {
    if (!std::isfinite(v)) return;
    const double bin = hi > lo ? (v - lo) / (hi - lo) * kBins : 0;
    counts[static_cast<std::size_t>(std::min(bin, kBins - 1.0))] += n;
    total += n;
  };
  for (auto it = grid.cbeginValueOn(); it; ++it) add(*it, static_cast<double>(it.getVoxelCount()));
  double rest = box.size.cast<double>().prod() - static_cast<double>(grid.activeVoxelCount());
  for (const auto& [v, n] : inactive) {
    add(v, n);
    rest -= n;
  }
  add(background, std::max(rest, 0.0));
  const auto quantile = [&](double share) {
    std::size_t bin = 0;
    for (double sum = counts[0]; sum < share * total && bin + 1 < kBins;) sum += counts[++bin];
    return lo + (hi - lo) * static_cast<double>(share < 0.5 ? bin : bin + 1) / kBins;
  };
  out["range"] = {lo, hi};
  out["shown"] = {quantile(0.005), quantile(0.995)};
  out["most"] = quantile(0.8);
}

}  // namespace

json volume_head(const Volume& volume) {
  const VoxelBox box = voxel_box(volume);
  json grids = json::array();
  for (const auto& g : volume.grids) {
    json j = {{"name", g->getName()}, {"type", g->valueType()}};
    const auto range = [&](const auto* grid) {
      if (grid) add_ranges(j, *grid, box);
    };
    range(dynamic_cast<const openvdb::FloatGrid*>(g.get()));
    range(dynamic_cast<const openvdb::DoubleGrid*>(g.get()));
    grids.push_back(j);
  }
  const auto list = [](const auto& v) { return json{v[0], v[1], v[2]}; };
  return {{"size", list(box.size)}, {"spacing", list(box.spacing)}, {"grids", grids}};
}

std::string slice_view(const Volume& volume, const Slice& s, int most) {
  const VoxelBox box = voxel_box(volume);
  const int u = std::clamp(s.axis, 0, 2);
  const int a = kSliceColumns[static_cast<std::size_t>(u)], b = kSliceRows[static_cast<std::size_t>(u)];
  const int width = box.size[a], height = box.size[b];
  const int factor = std::max(1, (std::max(width, height) + most - 1) / most);
  const int index = std::clamp(s.index, 0, box.size[u] - 1);
  std::string out;
  for (const int v :
       {(width + factor - 1) / factor, (height + factor - 1) / factor, box.size[u], width, height})
    append(out, static_cast<std::uint32_t>(v));
  with_colors(grid_of(volume, s.grid), s.lo, s.hi, [&](auto&& color, bool) {
    Eigen::Vector3i at;
    at[u] = box.first[u] + index;
    for (int y = 0; y < height; y += factor)
      for (int x = 0; x < width; x += factor) {
        at[a] = box.first[a] + x;
        at[b] = box.first[b] + height - 1 - y;
        append(out, color(openvdb::Coord(at[0], at[1], at[2])));
      }
  });
  return out;
}

std::string voxels_view(const Volume& volume, const Slice& s, int most) {
  constexpr int kMost = 256;
  const VoxelBox box = voxel_box(volume);
  most = std::min(most, kMost);
  const int factor = std::max(1, (box.size.maxCoeff() + most - 1) / most);
  std::string out;
  for (int k = 0; k < 3; ++k) append(out, static_cast<std::uint32_t>((box.size[k] + factor - 1) / factor));
  append(out, static_cast<std::uint32_t>(factor));
  const auto& grid = grid_of(volume, s.grid);
  const auto material = coverage(volume);
  with_colors(grid, s.lo, s.hi, [&](auto&& color, bool quantity) {
    const auto voxels = [&](auto&& alpha) {
      for (int z = 0; z < box.size.z(); z += factor)
        for (int y = 0; y < box.size.y(); y += factor)
          for (int x = 0; x < box.size.x(); x += factor) {
            const openvdb::Coord at(box.first.x() + x, box.first.y() + y, box.first.z() + z);
            const std::uint32_t c = color(at);
            append(out, (c & 0xffffffu) | alpha(at, c) << 24);
          }
    };
    if (material && !quantity)
      voxels([in = material->getConstAccessor()](const openvdb::Coord& at, std::uint32_t) {
        const float v = in.getValue(at);
        return static_cast<std::uint32_t>(
            std::lround(255 * (std::isfinite(v) ? std::clamp(v, 0.0f, 1.0f) : 0)));
      });
    else
      voxels([&](const openvdb::Coord&, std::uint32_t c) { return quantity ? c & 255u : 255u; });
  });
  return out;
}

}  // namespace terrazzo::studio
