#include "nodes/cooccurrence/texture_nib/nib_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/cooccurrence.h"

namespace terrazzo::texture_nib {

NibTexture learn(const Image& picture, const std::vector<std::uint8_t>& region, const NibOptions& s,
                 const Work& work) {
  NibTexture t;
  std::vector<Vec3f> colors;
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i]) colors.push_back(picture.pixels[i]);
  if (colors.empty())
    throw Error("no-pixels", "the region contains no pixel of the picture", "draw it inside the picture")
        .parameter("region");
  t.levels = color_levels(colors, s.levels, s.space, s.seed, work);
  const int levels = t.levels.count();
  t.colors.assign(picture.pixels.begin(), picture.pixels.begin() + region.size());
  t.positions.resize(region.size(), Vec3f::Zero());
  t.level.assign(region.size(), kNoLevel);
  t.pixels_of.resize(levels);
  t.histogram.assign(levels, 0);
  std::vector<float> distances;
  for (std::size_t i = 0; i < region.size(); ++i) {
    if (i % 4096 == 0) work.check();
    if (!picture.pixels[i].allFinite())
      throw Error("bad-pixels", "the picture contains NaN or infinity", "repair it before this node");
    t.positions[i] = t.levels.position(picture.pixels[i]);
    if (!region[i]) continue;
    float d = 0;
    const int k = t.levels.nearest(t.positions[i], &d);
    t.level[i] = k;
    t.pixels_of[k].push_back(i);
    t.histogram[k] += 1.0 / colors.size();
    distances.push_back(std::sqrt(d));
  }
  for (int k = 1; k < levels; ++k) t.histogram[k] += t.histogram[k - 1];
  // Exclude the region's own outliers.
  const std::size_t far = (distances.size() - 1) * 0.99;
  t.threshold = s.threshold >= 0 ? s.threshold : 1.25 * at_rank(distances, far);

  LevelField field(Vec3i(picture.width, picture.height, 1));
  field.at = t.level;
  t.offsets = cooccurrence_offsets(s.extent, s.scales);
  const Cooccurrence c = measure_cooccurrence(field, levels, t.offsets, false, work);
  t.width = (levels + 7) / 8 * 8;
  const auto rows = static_cast<std::size_t>(levels + 1) * t.width;
  t.by_home.assign(t.offsets.size() * rows, 0);
  t.by_remote.assign(t.offsets.size() * rows, 0);
  for (std::size_t d = 0; d < t.offsets.size(); ++d) {
    if (c.pairs[d] == 0)
      throw Error(
          "too-small",
          fmt::format("the region has no two pixels at offset ({}, {})", t.offsets[d].x(), t.offsets[d].y()),
          "the region must be larger than the kernel: enlarge it, or reduce extent or scales")
          .parameter("region");
    for (int h = 0; h < levels; ++h)
      for (int r = 0; r < levels; ++r) {
        const float p = static_cast<double>(c.counts[c.at(d, h, r)]) / c.pairs[d];
        t.by_home[d * rows + static_cast<std::size_t>(h) * t.width + r] = p;
        t.by_remote[d * rows + static_cast<std::size_t>(r) * t.width + h] = p;
      }
  }
  return t;
}

}  // namespace terrazzo::texture_nib
