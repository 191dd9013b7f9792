#include "nodes/residual_synth/residual_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace terrazzo {
namespace {

// Chessboard distance to the nearest pixel of another label, minus one and capped: 0 beside an outline.
std::vector<std::uint8_t> depth_in_label(const Labels& labels, int section, int cap) {
  const int w = labels.width, h = labels.height;
  std::vector<std::uint8_t> depth(static_cast<std::size_t>(w) * h, static_cast<std::uint8_t>(cap));
  std::vector<std::uint8_t> next;
  const auto id = [&](int x, int y) { return labels.ids[labels.index(x, y, section)]; };
  const auto around = [&](int x, int y, auto&& test) {
    for (int v = std::max(0, y - 1); v <= std::min(h - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(w - 1, x + 1); ++u)
        if (test(u, v)) return true;
    return false;
  };
  for (int step = 0; step < cap; ++step) {
    next = depth;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * w + x;
        if (depth[at] < cap) continue;
        const bool edge = step == 0 ? around(x, y, [&](int u, int v) { return id(u, v) != id(x, y); })
                                    : around(x, y, [&](int u, int v) {
                                        return depth[static_cast<std::size_t>(v) * w + u] < cap;
                                      });
        if (edge) next[at] = static_cast<std::uint8_t>(step);
      }
    depth.swap(next);
  }
  return depth;
}

// For every pixel the nearest valid one, by two sweeps that hand on the neighbours' (Danielsson 1980).
std::vector<std::int32_t> nearest_valid(const std::vector<std::uint8_t>& valid, int w, int h) {
  std::vector<std::int32_t> nearest(valid.size(), -1);
  for (std::size_t i = 0; i < valid.size(); ++i)
    if (valid[i]) nearest[i] = static_cast<std::int32_t>(i);
  const auto offer = [&](int x, int y, int u, int v) {
    if (u < 0 || v < 0 || u >= w || v >= h) return;
    const std::int32_t candidate = nearest[static_cast<std::size_t>(v) * w + u];
    if (candidate < 0) return;
    auto& best = nearest[static_cast<std::size_t>(y) * w + x];
    const auto distance = [&](std::int32_t i) {
      const double dx = i % w - x, dy = i / w - y;
      return dx * dx + dy * dy;
    };
    if (best < 0 || distance(candidate) < distance(best)) best = candidate;
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x)
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) offer(x, y, x + dx, y + dy);
    for (int x = w - 1; x >= 0; --x) offer(x, y, x + 1, y);
  }
  for (int y = h - 1; y >= 0; --y) {
    for (int x = w - 1; x >= 0; --x)
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) offer(x, y, x + dx, y + dy);
    for (int x = 0; x < w; ++x) offer(x, y, x - 1, y);
  }
  return nearest;
}

}  // namespace

ResidualImage residual_image(const Image& image, const Labels& labels, int edge, const Work& work) {
  if (image.width != labels.width || image.height != labels.height || image.sections != labels.sections)
    throw Error(
        "size-mismatch",
        fmt::format("the image has {} × {} pixels in {} sections, the labels {} × {} in {}", image.width,
                    image.height, image.sections, labels.width, labels.height, labels.sections),
        "take labels of the same photograph");
  for (const auto& p : image.pixels)
    if (!p.allFinite()) throw Error("bad-pixels", "the image holds NaN or infinity");
  const std::size_t plane = static_cast<std::size_t>(image.width) * image.height;
  ResidualImage out;
  out.image = image, out.edge = edge;
  std::vector<std::uint8_t> depth;
  for (int s = 0; s < image.sections; ++s) {
    work.check();
    const auto d = depth_in_label(labels, s, edge);
    depth.insert(depth.end(), d.begin(), d.end());
  }
  const auto kept = [&](int band) {
    return std::count_if(depth.begin(), depth.end(), [&](std::uint8_t d) { return d >= band; });
  };
  while (out.edge > 0 && 10 * static_cast<std::size_t>(kept(out.edge)) < depth.size()) --out.edge;
  out.filled = 1 - static_cast<double>(kept(out.edge)) / static_cast<double>(depth.size());

  Vec3 total = Vec3::Zero();
  for (int s = 0; s < image.sections; ++s) {
    work.check();
    const std::size_t begin = s * plane;
    struct Mean {
      Vec3 sum = Vec3::Zero();
      double count = 0;
    };
    std::map<std::int32_t, Mean> means;
    std::vector<std::uint8_t> valid(plane);
    for (std::size_t i = 0; i < plane; ++i) {
      valid[i] = depth[begin + i] >= out.edge;
      if (!valid[i]) continue;
      Mean& m = means[labels.ids[begin + i]];
      m.sum += image.pixels[begin + i].cast<double>(), ++m.count;
    }
    Vec3f* residual = &out.image.pixels[begin];
    for (std::size_t i = 0; i < plane; ++i)
      if (valid[i]) {
        const Mean& m = means[labels.ids[begin + i]];
        residual[i] -= (m.sum / m.count).cast<float>();
      }
    const auto nearest = nearest_valid(valid, image.width, image.height);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * image.width + x;
        if (valid[i]) continue;
        if (nearest[i] < 0) {
          residual[i] = Vec3f::Zero();  // a section of outlines alone
          continue;
        }
        const int nx = nearest[i] % image.width, ny = nearest[i] / image.width;
        const int mx = 2 * nx - x, my = 2 * ny - y;
        const bool inside = mx >= 0 && my >= 0 && mx < image.width && my < image.height;
        const std::size_t mirror = inside ? static_cast<std::size_t>(my) * image.width + mx : 0;
        residual[i] = residual[inside && valid[mirror] ? mirror : static_cast<std::size_t>(nearest[i])];
      }
    for (std::size_t i = 0; i < plane; ++i) total += residual[i].cast<double>();
  }
  const Vec3f mean = (total / static_cast<double>(out.image.pixels.size())).cast<float>();
  for (auto& p : out.image.pixels) p -= mean;
  return out;
}

}  // namespace terrazzo
