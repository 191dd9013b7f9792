#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/photograph/load_ebsd/grid.h"
#include "runtime/memory.h"

namespace terrazzo::load_ebsd {
namespace {

constexpr double kMostPixels = 2147483647.0;
// Resampling a few points to very many pixels is a mistake in the file.
constexpr double kMostPixelsPerPoint = 100;

void check_size(const Grid& g, double pixel, std::uint64_t memory, const Lines& lines) {
  const double points = static_cast<double>(g.width) * g.rows;
  const double pixels = points * (g.x_step / pixel) * (g.y_step / pixel);
  if (pixels > kMostPixels)
    lines.unreadable(fmt::format("it would have {:.3g} square pixels; the limit is {}", pixels, kMostPixels));
  if (pixels > kMostPixelsPerPoint * points)
    lines.unreadable(fmt::format("its steps {} and {} µm differ too much", g.x_step, g.y_step));
  require_memory(pixels * sizeof(MapPoint), memory, "the pixels of the map");
}

void transpose(EbsdMap& map) {
  std::vector<MapPoint> out(map.points.size());
  const std::size_t width = map.width, height = map.height;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) out[x * height + y] = map.points[y * width + x];
  map.points = std::move(out);
  std::swap(map.width, map.height);
}

}  // namespace

EbsdMap rasterize(const Grid& g, const PointList& p, std::vector<Phase> phases, std::uint64_t memory,
                  const Lines& lines) {
  EbsdMap out;
  out.phases = std::move(phases);
  out.missing = g.missing;
  out.pixel_size = std::min(g.x_step, g.y_step);
  const double pixel = out.pixel_size;
  check_size(g, pixel, memory, lines);
  const auto at = [&](std::int64_t row, std::int64_t column) {
    const std::int32_t i = g.points[row * g.width + column];
    return i < 0 ? MapPoint{} : p.points[i];
  };
  // Steps that differ by less than half a pixel over the whole map are equal.
  const double most = std::max(g.width, g.rows);
  if (!g.staggered && std::abs(g.x_step - g.y_step) * most < 0.5 * pixel) {
    out.width = g.width;
    out.height = g.rows;
    out.points.reserve(g.points.size());
    for (std::int64_t y = 0; y < g.rows; ++y)
      for (std::int64_t x = 0; x < g.width; ++x) out.points.push_back(at(y, x));
    return out;
  }
  const auto across = g.staggered ? std::min(g.columns[0], g.columns[1]) : g.width;
  out.width = std::max(1, round_nearest(across * g.x_step / pixel));
  out.height = std::max(1, round_nearest(g.rows * g.y_step / pixel));
  out.points.reserve(pixels_in(out.width, out.height));
  // Points are in the middle of their cells; those of shifted rows half a step further.
  for (int y = 0; y < out.height; ++y) {
    const auto row = std::clamp<std::int64_t>((y + 0.5) * pixel / g.y_step, std::int64_t{0}, g.rows - 1);
    const int shift = g.shift(row);
    for (int x = 0; x < out.width; ++x) {
      const double place = (x + 0.5) * pixel / g.x_step - 0.5 * shift;
      out.points.push_back(
          at(row, std::clamp<std::int64_t>(std::floor(place), std::int64_t{0}, g.columns[shift] - 1)));
    }
  }
  if (g.transposed) transpose(out);
  return out;
}

}  // namespace terrazzo::load_ebsd
