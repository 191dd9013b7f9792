#include "nodes/common/texture/footprint.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo {

std::vector<std::uint32_t> capsule(int width, int height, const Vec2& from, const Vec2& to, double radius) {
  std::vector<std::uint32_t> out;
  const Vec2 lo = from.cwiseMin(to).array() - radius, hi = from.cwiseMax(to).array() + radius;
  const int x0 = std::max(0, round_down(std::max(lo.x(), 0.0))),
            y0 = std::max(0, round_down(std::max(lo.y(), 0.0))),
            x1 = static_cast<int>(std::min<double>(width, std::ceil(hi.x()))),
            y1 = static_cast<int>(std::min<double>(height, std::ceil(hi.y())));
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const Vec2 p(x + 0.5, y + 0.5);
      const double t = length2 > 0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0.0;
      if ((p - from - t * along).squaredNorm() <= radius * radius)
        out.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) + x);
    }
  return out;
}

std::vector<std::uint32_t> surrounded(int width, int height, const std::vector<std::vector<Vec2>>& outlines) {
  std::vector<std::uint32_t> out;
  std::vector<double> crossings;
  for (int y = 0; y < height; ++y) {
    const double at = y + 0.5;
    crossings.clear();
    for (const auto& outline : outlines)
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        if ((a.y() <= at) != (b.y() <= at))
          crossings.push_back(a.x() + (at - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
      }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const int x0 = static_cast<int>(std::clamp<double>(std::ceil(crossings[i] - 0.5), 0.0, width)),
                x1 = static_cast<int>(std::clamp<double>(std::ceil(crossings[i + 1] - 0.5), 0.0, width));
      for (int x = x0; x < x1; ++x)
        out.push_back(static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) + x);
    }
  }
  return out;
}

std::vector<std::uint32_t> footprint_of(const Stroke& s, int width, int height, double margin) {
  std::vector<std::uint32_t> out;
  const auto take = [&](const std::vector<std::uint32_t>& pixels) {
    out.insert(out.end(), pixels.begin(), pixels.end());
  };
  if (s.area) take(surrounded(width, height, s.parts));
  for (const auto& part : s.parts)
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (!s.area)
        take(capsule(width, height, part[i > 0 ? i - 1 : 0], part[i], s.radius + margin));
      else if (margin > 0)
        take(capsule(width, height, part[i], part[(i + 1) % part.size()], margin));
    }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace terrazzo
