#include "nodes/common/texture/color_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/kmeans.h"
#include "nodes/data/labels.h"
#include "runtime/random.h"

namespace terrazzo {

Vec3f ColorLevels::position(const Vec3f& linear) const {
  return space == ColorSpace::Oklab ? linear_to_oklab(linear) : linear_to_srgb(linear);
}

int ColorLevels::nearest(const Vec3f& p, float* distance2) const {
  int best = 0;
  float least = (p - center[0]).squaredNorm();
  for (int k = 1; k < count(); ++k)
    if (const float d = (p - center[k]).squaredNorm(); d < least) {
      least = d;
      best = k;
    }
  if (distance2) *distance2 = least;
  return best;
}

ColorLevels color_levels(const std::vector<Vec3f>& linear, int levels, ColorSpace space, std::uint64_t seed,
                         const Work& work) {
  if (linear.empty()) throw Error("no-pixels", "the texture has no pixels");
  for (const auto& p : linear)
    if (!p.allFinite())
      throw Error("bad-pixels", "the image contains NaN or infinity",
                  "replace those pixels before this node");
  ColorLevels out;
  out.space = space;
  constexpr std::size_t kMost = 16384;
  std::vector<Vec3> points;
  const std::size_t n = std::min(kMost, linear.size());
  for (std::size_t i = 0; i < n; ++i) {
    // One of each of n equal runs, so that no period of the image is favored.
    const std::size_t lo = i * linear.size() / n, hi = (i + 1) * linear.size() / n;
    const std::size_t at = lo + Random(seed, 0x1e7e, i).below(hi - lo);
    points.push_back(out.position(linear[at]).cast<double>());
  }
  const ColorClusters clusters = kmeans(points, std::vector<double>(points.size(), 1.0), levels, seed, work);
  if (clusters.k < 2)
    throw Error("one-color",
                "all pixels of the texture have the same color, so there are no statistics to match",
                "choose a region or image with more than one color");
  std::vector<Vec3> mean = clusters.mean;
  std::sort(mean.begin(), mean.end(), [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  for (const auto& m : mean) {
    const Vec3f c = m.cast<float>();
    out.center.push_back(c);
    out.color.push_back(space == ColorSpace::Oklab ? oklab_to_linear(c) : srgb_to_linear(c));
  }
  return out;
}

LevelField levels_of(const Image& image, int section, const ColorLevels& levels,
                     const std::vector<std::uint8_t>& mask, const Work& work) {
  LevelField out(Vec3i(image.width, image.height, 1), kNoLevel);
  const std::size_t first = image.index(0, 0, section);
  work.parallel(image.height, 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * image.width; i < end * image.width; ++i)
      if (mask.empty() || mask[first + i])
        out.at[i] = levels.nearest(levels.position(image.pixels[first + i]));
  });
  return out;
}

std::vector<std::uint8_t> mask_of(const Value& value, const Image& picture, const std::string& input) {
  const bool labels = value.is<Labels>();
  const Labels* l = labels ? &value.as<Labels>() : nullptr;
  const Image* m = labels ? nullptr : &value.as<Image>();
  const int width = l ? l->width : m->width, height = l ? l->height : m->height,
            sections = l ? l->sections : m->sections;
  if (width != picture.width || height != picture.height || (sections != picture.sections && sections != 1))
    throw Error("wrong-size",
                fmt::format("{} has {} × {} pixels in {} sections, but the image has {} × {} in {}", input,
                            width, height, sections, picture.width, picture.height, picture.sections),
                "use a mask of the same size as the image");
  const std::size_t n = picture.pixels.size(), own = l ? l->ids.size() : m->pixels.size();
  std::vector<std::uint8_t> out(n);
  for (std::size_t i = 0; i < n; ++i)
    out[i] = own == 0 ? 0 : l ? l->ids[i % own] != 0 : m->pixels[i % own].mean() > 0.2f;
  return out;
}

}  // namespace terrazzo
