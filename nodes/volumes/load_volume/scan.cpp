#include "nodes/volumes/load_volume/scan.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/smallest_voxel.h"
#include "nodes/data/indices.h"

namespace terrazzo::load_volume {

void require_voxels(const LoadedScan& s, const std::string& file, const Reading& reading, double more) {
  if (s.size.minCoeff() < 1)
    throw Error("empty-volume",
                fmt::format("'{}' is {} × {} × {} voxels", file, s.size.x(), s.size.y(), s.size.z()));
  const double voxels = s.size.cast<double>().prod();
  if (voxels > 2147483648.0)
    throw Error(
        "too-large",
        fmt::format("'{}' is {} × {} × {} voxels, more than 2^31", file, s.size.x(), s.size.y(), s.size.z()),
        "crop or downsample it first");
  require_memory(2 * sizeof(float) * voxels + more, reading.memory, "the volume in '" + file + "'");
}

void allocate(LoadedScan& s, const std::string& file, const Reading& reading, double more) {
  require_voxels(s, file, reading, more);
  s.values.resize(s.size.cast<double>().prod());
}

void require_representable(const Vec3& s) {
  if (s.prod() >= kSmallestVoxel) return;
  throw Error(
      "bad-spacing",
      fmt::format("the voxels are {:.6g} × {:.6g} × {:.6g} mm; grids hold voxels from about 15 nm on", s.x(),
                  s.y(), s.z()),
      fmt::format("set spacing in another unit, such as [{:.6g}, {:.6g}, {:.6g}] for nm, and read all "
                  "lengths of the result in that unit",
                  1e6 * s.x(), 1e6 * s.y(), 1e6 * s.z()))
      .parameter("spacing");
}

void check_plausible(double bytes, const std::filesystem::path& path) {
  std::error_code none;
  const auto size = std::filesystem::file_size(path, none);
  if (none || bytes <= 2000.0 * size + 1e6) return;
  throw Error("unreadable-volume",
              fmt::format("'{}' has {} bytes, too few for the {:.3g} bytes of voxels in its header",
                          path.string(), size, bytes),
              "check that the file is complete");
}

void align_axes(LoadedScan& s, const Mat3& axes) {
  // Choose the assignment of index axes to axes of space that best preserves their directions.
  static constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::array<int, 3> to = kOrders[0];  // index axis k becomes axis to[k]
  double best = -1;
  for (const auto& o : kOrders) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::abs(axes(o[k], k)) / axes.col(k).norm();
    if (sum > best + 1e-9) {
      best = sum;
      to = o;
    }
  }
  double worst = 1;
  for (int k = 0; k < 3; ++k) worst = std::min(worst, std::abs(axes(to[k], k)) / axes.col(k).norm());
  if (worst < std::cos(0.0175))
    s.notes.push_back(fmt::format("its slices are tilted by {:.1f} degrees; the tilt is ignored",
                                  std::acos(worst) * 57.2957795));
  std::array<int, 3> from{};
  std::array<bool, 3> flipped{};
  bool same = true;
  for (int k = 0; k < 3; ++k) {
    from[to[k]] = k;
    flipped[to[k]] = axes(to[k], k) < 0;
    same = same && to[k] == k && axes(k, k) > 0;
  }
  if (same) return;
  const Vec3i old = s.size;
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(old.x()),
                                             pixels_in(old.x(), old.y())};
  const Vec3 spacing = s.spacing;
  for (int k = 0; k < 3; ++k) {
    s.size[k] = old[from[k]];
    s.spacing[k] = spacing[from[k]];
  }
  const auto at = [&](int axis, int i) {
    return stride[from[axis]] * (flipped[axis] ? s.size[axis] - 1 - i : i);
  };
  const auto turn = [&](auto& numbers) {
    if (numbers.empty()) return;
    std::remove_reference_t<decltype(numbers)> turned;
    turned.reserve(numbers.size());
    for (int z = 0; z < s.size.z(); ++z)
      for (int y = 0; y < s.size.y(); ++y)
        for (int x = 0; x < s.size.x(); ++x) turned.push_back(numbers[at(0, x) + at(1, y) + at(2, z)]);
    numbers = std::move(turned);
  };
  turn(s.values);
  turn(s.whole);
}

}  // namespace terrazzo::load_volume
