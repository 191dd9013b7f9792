#include "nodes/photograph/segment/outline/outline.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

struct Window {
  int left = 1 << 30, top = 1 << 30, right = -1, bottom = -1;
};

// Values at pixel centers, with a margin of one pixel. A contour point is on a cell edge between two pixel
// centers.
class Contour {
 public:
  Contour(std::span<const std::int32_t> labels, std::span<const float> coverage, int width, int height,
          std::int32_t id, const Window& w)
      : left_(w.left - 1), top_(w.top - 1), columns_(w.right - w.left + 3), rows_(w.bottom - w.top + 3) {
    value_.assign(pixels_in(columns_, rows_), 0.0f);
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) {
        const int u = left_ + x, v = top_ + y;
        if (u < 0 || v < 0 || u >= width || v >= height) continue;
        const std::size_t i = pixel_at(u, v, width);
        value_[at(x, y)] = labels[i] == id  ? std::max(coverage[i], 0.502f)
                           : labels[i] == 0 ? std::min(coverage[i], 0.498f)
                                            : 0.0f;
      }
  }

  // All loops as crossing points in pixels from the top left corner of the image, y down. Each loop keeps the
  // inside to its left once y points up.
  std::vector<std::vector<Vec2>> loops() {
    // A directed segment enters a cell through one edge and leaves it through another: next_[edge] is the
    // next edge of the loop. Edge indices: 2·(cell corner index) + 0 for the edge to the right, + 1 for the
    // edge down.
    next_.assign(2 * value_.size(), -1);
    for (int y = 0; y + 1 < rows_; ++y)
      for (int x = 0; x + 1 < columns_; ++x) cell(x, y);
    std::vector<std::vector<Vec2>> all;
    for (std::size_t e = 0; e < next_.size(); ++e) {
      if (next_[e] < 0) continue;
      std::vector<Vec2> loop;
      std::int32_t i = e;
      while (next_[i] >= 0) {
        loop.push_back(point(i));
        const std::int32_t n = next_[i];
        next_[i] = -1;
        i = n;
      }
      all.push_back(std::move(loop));
    }
    return all;
  }

 private:
  std::size_t at(int x, int y) const { return pixel_at(x, y, columns_); }
  bool in(int x, int y) const { return value_[at(x, y)] >= 0.5f; }
  std::int32_t right_of(int x, int y) const { return 2 * at(x, y); }
  std::int32_t down_of(int x, int y) const { return 2 * at(x, y) + 1; }

  void cell(int x, int y) {
    const std::int32_t top = right_of(x, y), bottom = right_of(x, y + 1), left = down_of(x, y),
                       right = down_of(x + 1, y);
    auto go = [&](std::int32_t from, std::int32_t to) { next_[from] = to; };
    // Corners in reading order: 1 top left, 2 top right, 4 bottom left, 8 bottom right. The inside is to the
    // right of each segment on the screen, and so to its left once y points up.
    switch (in(x, y) + 2 * in(x + 1, y) + 4 * in(x, y + 1) + 8 * in(x + 1, y + 1)) {
      case 1:
        go(left, top);
        break;
      case 2:
        go(top, right);
        break;
      case 3:
        go(left, right);
        break;
      case 4:
        go(bottom, left);
        break;
      case 5:
        go(bottom, top);
        break;
      case 6:
        go(top, left);
        go(bottom, right);
        break;  // diagonal corners are joined
      case 7:
        go(bottom, right);
        break;
      case 8:
        go(right, bottom);
        break;
      case 9:
        go(left, bottom);
        go(right, top);
        break;  // diagonal corners are joined
      case 10:
        go(top, bottom);
        break;
      case 11:
        go(left, bottom);
        break;
      case 12:
        go(right, left);
        break;
      case 13:
        go(right, top);
        break;
      case 14:
        go(top, left);
        break;
      default:
        break;
    }
  }

  Vec2 point(std::int32_t edge) const {
    const int corner = edge / 2, x = corner % columns_, y = corner / columns_;
    const float a = value_[corner], b = edge % 2 ? value_[corner + columns_] : value_[corner + 1];
    const double t = (0.5 - a) / (static_cast<double>(b) - a);
    return {left_ + x + 0.5 + (edge % 2 ? 0 : t), top_ + y + 0.5 + (edge % 2 ? t : 0)};
  }

  int left_, top_, columns_, rows_;
  std::vector<float> value_;
  std::vector<std::int32_t> next_;
};

}  // namespace

std::vector<LabelOutline> outlines(std::span<const std::int32_t> labels, std::span<const float> coverage,
                                   int width, int height, int count, const Work& work, std::int32_t first) {
  std::vector<Window> windows(count);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::int32_t id = labels[pixel_at(x, y, width)];
      if (id < first || id >= first + count) continue;
      Window& w = windows[id - first];
      w.left = std::min(w.left, x);
      w.right = std::max(w.right, x);
      w.top = std::min(w.top, y);
      w.bottom = std::max(w.bottom, y);
    }
  std::vector<LabelOutline> out(count);
  work.parallel(count, 16, [&](std::size_t b, std::size_t e) {
    for (std::size_t k = b; k < e; ++k) {
      if (windows[k].right < 0) continue;
      Contour contour(labels, coverage, width, height, static_cast<std::int32_t>(k) + first, windows[k]);
      LabelOutline& o = out[k];
      Vec2 moment = Vec2::Zero();
      double largest = 0;
      for (auto& loop : contour.loops()) {
        for (auto& p : loop) p.y() = height - p.y();
        double twice = 0;
        Vec2 m = Vec2::Zero();
        for (std::size_t i = 0; i < loop.size(); ++i) {
          const Vec2 &p = loop[i], &q = loop[(i + 1) % loop.size()];
          const double c = p.x() * q.y() - p.y() * q.x();
          twice += c;
          m += c * (p + q);
        }
        o.area += twice / 2;
        moment += m / 6;
        if (twice > largest) {
          largest = twice;
          o.points = std::move(loop);
        }
      }
      if (o.area > 0) o.centroid = moment / o.area;
    }
  });
  return out;
}

}  // namespace terrazzo::segment
