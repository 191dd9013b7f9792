#include "nodes/detail/residual_synth/residual_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/common/texture/color.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/specks.h"

namespace terrazzo::residual_synth {
namespace {

// Chessboard distance to the nearest pixel of another label, minus one and capped: 0 beside an outline.
std::vector<std::uint8_t> depth_in_label(const Labels& labels, int section, int cap, const Work& work) {
  const int w = labels.width, h = labels.height;
  std::vector<std::uint8_t> depth(pixels_in(w, h), static_cast<std::uint8_t>(cap));
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
    work.part(0, 0).parallel(h, 64, [&](std::size_t begin, std::size_t end) {
      for (int y = begin; y < static_cast<int>(end); ++y)
        for (int x = 0; x < w; ++x) {
          const std::size_t at = pixel_at(x, y, w);
          if (depth[at] < cap) continue;
          const bool edge = step == 0
                                ? around(x, y, [&](int u, int v) { return id(u, v) != id(x, y); })
                                : around(x, y, [&](int u, int v) { return depth[pixel_at(u, v, w)] < cap; });
          if (edge) next[at] = step;
        }
    });
    depth.swap(next);
  }
  return depth;
}

// For every pixel the nearest valid one, by two sweeps that propagate the neighbors' (Danielsson 1980).
std::vector<std::int32_t> nearest_valid(const std::vector<std::uint8_t>& valid, int w, int h) {
  std::vector<std::int32_t> nearest(valid.size(), -1);
  for (std::size_t i = 0; i < valid.size(); ++i)
    if (valid[i]) nearest[i] = i;
  const auto offer = [&](int x, int y, int u, int v) {
    if (u < 0 || v < 0 || u >= w || v >= h) return;
    const std::int32_t candidate = nearest[pixel_at(u, v, w)];
    if (candidate < 0) return;
    auto& best = nearest[pixel_at(x, y, w)];
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

// Invalidates specks and binder pixels within `edge` of them. Returns the number of specks.
std::size_t clear_specks(const Vec3f* pixels, const std::int32_t* ids, double limit, int edge, int w, int h,
                         std::vector<std::uint8_t>& valid) {
  std::vector<std::uint8_t> binder(valid.size());
  for (std::size_t i = 0; i < valid.size(); ++i) binder[i] = valid[i] && ids[i] == 0;
  const std::vector<std::size_t> far = residual::find_specks(pixels, binder, limit);
  for (const std::size_t i : far) {
    const int x = i % static_cast<std::size_t>(w), y = i / static_cast<std::size_t>(w);
    for (int b = std::max(0, y - edge); b <= std::min(h - 1, y + edge); ++b)
      for (int a = std::max(0, x - edge); a <= std::min(w - 1, x + edge); ++a)
        valid[static_cast<std::size_t>(b) * w + a] = 0;
  }
  return far.size();
}

// Subtracts from each pixel the mean of its label's valid pixels (of all its pixels if none is valid) and
// stores the mean in `means`.
void subtract_means(Vec3f* pixels, Vec3f* means, const std::int32_t* ids,
                    const std::vector<std::uint8_t>& valid) {
  struct Sum {
    Vec3 valid = Vec3::Zero(), all = Vec3::Zero();
    double valid_count = 0, count = 0;
    Vec3f mean() const {
      return (valid_count > 0 ? Vec3(valid / valid_count) : Vec3(all / count)).cast<float>();
    }
  };
  std::map<std::int32_t, Sum> sums;
  for (std::size_t i = 0; i < valid.size(); ++i) {
    Sum& s = sums[ids[i]];
    const Vec3 v = pixels[i].cast<double>();
    s.all += v;
    ++s.count;
    if (valid[i]) {
      s.valid += v;
      ++s.valid_count;
    }
  }
  std::map<std::int32_t, Vec3f> mean;
  for (const auto& [id, sum] : sums) mean[id] = sum.mean();
  for (std::size_t i = 0; i < valid.size(); ++i) {
    means[i] = mean.at(ids[i]);
    pixels[i] -= means[i];
  }
}

// Fills invalid pixels with the value mirrored at the nearest valid one, or with that pixel's value if the
// mirror image is invalid.
void fill(Vec3f* pixels, const std::vector<std::uint8_t>& valid, int w, int h) {
  const auto nearest = nearest_valid(valid, w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t i = pixel_at(x, y, w);
      if (valid[i]) continue;
      if (nearest[i] < 0) {
        pixels[i] = Vec3f::Zero();  // the section has only outlines
        continue;
      }
      const int mx = 2 * (nearest[i] % w) - x, my = 2 * (nearest[i] / w) - y;
      const bool inside = mx >= 0 && my >= 0 && mx < w && my < h;
      const std::size_t mirror = inside ? static_cast<std::size_t>(my) * w + mx : 0;
      pixels[i] = pixels[inside && valid[mirror] ? mirror : static_cast<std::size_t>(nearest[i])];
    }
}

}  // namespace

Image as_displayed(const Image& image, const Work& work) {
  Image out = image;
  work.parallel(out.pixels.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) out.pixels[i] = linear_to_srgb(out.pixels[i]);
  });
  return out;
}

ResidualImage residual_image(const Image& image, const Labels& labels, int edge, double specks,
                             const Work& work) {
  require_equal_size(image, "the image has", labels, "the labels have", "use labels of the same photograph");
  for (const auto& p : image.pixels)
    if (!p.allFinite()) throw Error("bad-pixels", "the image contains NaN or infinity");
  const int w = image.width, h = image.height;
  const std::size_t plane = pixels_in(w, h);
  ResidualImage out;
  out.image = out.means = image;
  out.edge = edge;
  std::vector<std::uint8_t> depth;
  for (int s = 0; s < image.sections; ++s) {
    const auto d = depth_in_label(labels, s, edge, work);
    depth.insert(depth.end(), d.begin(), d.end());
  }
  const auto kept = [&](int band) {
    return static_cast<std::size_t>(
        std::count_if(depth.begin(), depth.end(), [&](std::uint8_t d) { return d >= band; }));
  };
  while (out.edge > 0 && 10 * kept(out.edge) < depth.size()) --out.edge;

  Vec3 total = Vec3::Zero();
  std::size_t filled = 0, far = 0;
  for (int s = 0; s < image.sections; ++s) {
    work.check();
    Vec3f* pixels = &out.image.pixels[s * plane];
    const std::int32_t* ids = &labels.ids[s * plane];
    std::vector<std::uint8_t> valid(plane);
    for (std::size_t i = 0; i < plane; ++i) valid[i] = depth[s * plane + i] >= out.edge;
    if (specks > 0) far += clear_specks(pixels, ids, specks, edge, w, h, valid);
    subtract_means(pixels, &out.means.pixels[s * plane], ids, valid);
    fill(pixels, valid, w, h);
    for (std::size_t i = 0; i < plane; ++i) {
      total += pixels[i].cast<double>();
      filled += !valid[i];
    }
  }
  const double pixels = out.image.pixels.size();
  out.filled = filled / pixels;
  out.specks = far / pixels;
  const Vec3f mean = (total / pixels).cast<float>();
  for (auto& p : out.image.pixels) p -= mean;
  Vec3 binder = Vec3::Zero(), all = Vec3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < out.means.pixels.size(); ++i) {
    const Vec3 m = out.means.pixels[i].cast<double>();
    all += m;
    if (labels.ids[i] == 0) {
      binder += m;
      ++count;
    }
  }
  out.binder = (count > 0 ? Vec3(binder / count) : Vec3(all / pixels)).cast<float>();
  return out;
}

}  // namespace terrazzo::residual_synth
