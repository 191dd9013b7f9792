#include "nodes/bodies/cutting/raster.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"

namespace terrazzo::section {

namespace {

struct Bounds {
  int x0, y0, x1, y1;  // pixels, y up
};

Bounds bounds_of(const Region& region, const PixelGrid& grid) {
  const Extent e = region_extent(region);
  Bounds b{round_down(e.lo.x() / grid.mm_x), round_down(e.lo.y() / grid.mm_y),
           round_down(e.hi.x() / grid.mm_x) + 1, round_down(e.hi.y() / grid.mm_y) + 1};
  if (!grid.wrap) {
    b.x0 = std::max(b.x0, 0);
    b.y0 = std::max(b.y0, 0);
    b.x1 = std::min(b.x1, grid.width);
    b.y1 = std::min(b.y1, grid.height);
  }
  return b;
}

// Accumulates the signed area to the right of the directed edge: `area` is the share within a pixel, `rise`
// the share added to every pixel to its right. Coordinates are in pixels from the corner of the buffer.
void add_edge(Vec2 p, Vec2 q, int width, int height, std::vector<double>& area, std::vector<double>& rise) {
  if (p.y() == q.y()) return;
  const double sign = p.y() < q.y() ? -1 : 1;
  if (p.y() > q.y()) std::swap(p, q);
  const double slope = (q.x() - p.x()) / (q.y() - p.y());
  const int last_row = std::min(height - 1, round_down(q.y()));
  for (int y = std::max(0, round_down(p.y())); y <= last_row; ++y) {
    const double y0 = std::max<double>(y, p.y()), y1 = std::min<double>(y + 1, q.y());
    if (!(y1 > y0)) continue;
    double xa = p.x() + (y0 - p.y()) * slope, xb = p.x() + (y1 - p.y()) * slope;
    if (xa > xb) std::swap(xa, xb);
    const double total = y1 - y0;
    const int first = std::clamp(round_down(xa), 0, width - 1);
    const int last = std::clamp(round_down(xb), 0, width - 1);
    for (int x = first; x <= last; ++x) {
      const double left = x == first ? xa : x, right = x == last ? xb : x + 1;
      const double dy = xb > xa ? total * (right - left) / (xb - xa) : total;
      const std::size_t at = pixel_at(x, y, width);
      area[at] += sign * dy * (x + 1 - (left + right) / 2);
      rise[at] += sign * dy;
    }
  }
}

}  // namespace

void cover_pixels(const Region& region, const PixelGrid& grid,
                  const std::function<void(int, int, double)>& visit) {
  const Bounds b = bounds_of(region, grid);
  if (b.x0 >= b.x1 || b.y0 >= b.y1) return;
  const int width = b.x1 - b.x0, height = b.y1 - b.y0;
  std::vector<double> area(pixels_in(width, height), 0.0), rise = area;
  for (const Loop& l : region)
    for (std::size_t i = 0, j = l.size() - 1; i < l.size(); j = i++)
      add_edge({l[j].x() / grid.mm_x - b.x0, l[j].y() / grid.mm_y - b.y0},
               {l[i].x() / grid.mm_x - b.x0, l[i].y() / grid.mm_y - b.y0}, width, height, area, rise);
  for (int y = 0; y < height; ++y) {
    double carried = 0;
    for (int x = 0; x < width; ++x) {
      const std::size_t at = pixel_at(x, y, width);
      const double share = std::clamp(carried + area[at], 0.0, 1.0);
      carried += rise[at];
      if (share > 1e-9)
        visit(wrap_index(b.x0 + x, grid.width), grid.row(wrap_index(b.y0 + y, grid.height)), share);
    }
  }
}

void fill_pixels(const Region& region, const PixelGrid& grid, const std::function<void(int, int)>& visit) {
  const Bounds b = bounds_of(region, grid);
  std::vector<double> crossings;
  for (int y = b.y0; y < b.y1; ++y) {
    const double center = (y + 0.5) * grid.mm_y;
    crossings.clear();
    for (const Loop& l : region)
      for (std::size_t i = 0, j = l.size() - 1; i < l.size(); j = i++)
        if ((l[i].y() > center) != (l[j].y() > center))
          crossings.push_back(
              (l[j].x() + (l[i].x() - l[j].x()) * (center - l[j].y()) / (l[i].y() - l[j].y())) / grid.mm_x);
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const int from = std::max(b.x0, round_up(crossings[i] - 0.5));
      const int to = std::min(b.x1, round_up(crossings[i + 1] - 0.5));
      for (int x = from; x < to; ++x) visit(wrap_index(x, grid.width), grid.row(wrap_index(y, grid.height)));
    }
  }
}

}  // namespace terrazzo::section
