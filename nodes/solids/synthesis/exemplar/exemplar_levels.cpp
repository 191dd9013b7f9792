#include "nodes/solids/synthesis/exemplar/exemplar_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::solids {
namespace {

// The source pixels that make one pixel of a shorter line, and their weights.
struct Footprint {
  int first = 0;
  std::vector<float> weight;
};
std::vector<Footprint> footprints(int from, int to) {
  std::vector<Footprint> out(to);
  const double step = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double lo = i * step, hi = (i + 1) * step;
    auto& f = out[i];
    f.first = std::min<int>(from - 1, lo + 1e-9);
    for (int k = f.first; k < from && k < hi - 1e-9; ++k)
      f.weight.push_back((std::min<double>(hi, k + 1) - std::max<double>(lo, k)) / step);
  }
  return out;
}

template <class T>
std::vector<T> shrink(const std::vector<T>& in, int w0, int h0, int w, int h, const T& zero) {
  const auto fx = footprints(w0, w), fy = footprints(h0, h);
  std::vector<T> rows(static_cast<std::size_t>(w) * h0, zero);
  for (int y = 0; y < h0; ++y)
    for (int x = 0; x < w; ++x)
      for (std::size_t k = 0; k < fx[x].weight.size(); ++k)
        rows[pixel_at(x, y, w)] += fx[x].weight[k] * in[static_cast<std::size_t>(y) * w0 + fx[x].first + k];
  std::vector<T> out(pixels_in(w, h), zero);
  for (int y = 0; y < h; ++y)
    for (std::size_t k = 0; k < fy[y].weight.size(); ++k)
      for (int x = 0; x < w; ++x) out[pixel_at(x, y, w)] += fy[y].weight[k] * rows[(fy[y].first + k) * w + x];
  return out;
}

}  // namespace

SolidExemplar shrink(const SolidExemplar& e, int width, int height) {
  SolidExemplar out;
  out.width = width;
  out.height = height;
  const auto small = [&](const auto& all, const auto& zero) {
    return shrink(all, e.width, e.height, width, height, zero);
  };
  const Vec3f black = Vec3f::Zero();
  out.pixels = small(e.pixels, black);
  if (!e.features.empty()) out.features = small(e.features, black);
  if (!e.guide.empty()) out.guide = small(e.guide, 0.0f);
  if (!e.usable.empty())
    for (const float share : small(std::vector<float>(e.usable.begin(), e.usable.end()), 0.0f))
      out.usable.push_back(share > 0.999f);
  return out;
}

std::vector<ExemplarLevel> exemplar_levels(const SolidExemplar& working, int channels, int guided, int levels,
                                           double share, int most, int most_last, const Work& work) {
  std::vector<ExemplarLevel> out(levels);
  for (int l = levels - 1; l >= 0; --l) {
    work.check();
    ExemplarLevel& e = out[l];
    const int w = level_size(working.width, l, levels), h = level_size(working.height, l, levels);
    const bool full = l == levels - 1;
    const SolidExemplar small = full ? SolidExemplar{} : shrink(working, w, h);
    const SolidExemplar& s = full ? working : small;
    e.width = w;
    e.height = h;
    e.channels = channels + (l < guided && !s.guide.empty());
    e.texels.assign(4 * s.pixels.size(), 0.0f);
    for (std::size_t i = 0; i < s.pixels.size(); ++i)
      for (int c = 0; c < channels; ++c) e.texels[4 * i + c] = s.pixels[i][c];
    if (e.channels > channels)
      for (std::size_t i = 0; i < s.guide.size(); ++i) e.texels[4 * i + channels] = s.guide[i];
    e.usable.assign(s.pixels.size(), 0);
    // A summed-area table of unusable pixels, so that four lookups test a patch.
    std::vector<int> bad(static_cast<std::size_t>(w + 1) * (h + 1), 0);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        bad[static_cast<std::size_t>(y + 1) * (w + 1) + x + 1] =
            bad[static_cast<std::size_t>(y + 1) * (w + 1) + x] +
            bad[static_cast<std::size_t>(y) * (w + 1) + x + 1] -
            bad[static_cast<std::size_t>(y) * (w + 1) + x] +
            (!s.usable.empty() && !s.usable[pixel_at(x, y, w)]);
    const auto sum = [&](int x, int y) { return bad[static_cast<std::size_t>(y) * (w + 1) + x]; };
    for (int y = 0; y + kPatch <= h; ++y)
      for (int x = 0; x + kPatch <= w; ++x)
        if (sum(x + kPatch, y + kPatch) - sum(x, y + kPatch) - sum(x + kPatch, y) + sum(x, y) == 0) {
          e.usable[pixel_at(x, y, w)] = 1;
          e.starts.push_back(y * w + x);
        }
    if (e.starts.size() < 16)
      throw Error(
          "exemplar-too-small",
          fmt::format("the exemplar has only {2} usable patches of {3} × {4} at a scale of {0} × {1} pixels",
                      w, h, e.starts.size(), kPatch, kPatch),
          "use a larger exemplar, a mask that leaves more of it usable, or fewer levels");
    e.space = patch_space(e, share, full ? most_last : most);
    measure_patches(e, work.quiet());
  }
  return out;
}

}  // namespace terrazzo::solids
