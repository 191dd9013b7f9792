#include "nodes/photograph/instance_score/instance_score.h"

#include <algorithm>
#include <map>

#include "nodes/data/equal_size.h"

namespace terrazzo::instance_score {

int Score::matched(double overlap) const {
  return std::count_if(matches.begin(), matches.end(), [&](const Match& m) { return m.overlap >= overlap; });
}
double Score::average_precision(double overlap) const {
  const int m = matched(overlap), all = found + masks - m;
  return all > 0 ? static_cast<double>(m) / all : 1;
}
double Score::recall(double overlap) const {
  return masks > 0 ? static_cast<double>(matched(overlap)) / masks : 1;
}

Score compare_instances(const Labels& found, const Labels& masks) {
  require_equal_size(found, "the labels have", masks, "the masks have",
                     "connect labels and masks of the same image");
  std::map<std::int32_t, std::int64_t> found_size, mask_size;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int64_t> common;
  std::int64_t found_pixels = 0, mask_pixels = 0;
  for (std::size_t i = 0; i < found.ids.size(); ++i) {
    const std::int32_t f = found.ids[i], m = masks.ids[i];
    if (f > 0) {
      ++found_size[f];
      ++found_pixels;
    }
    if (m > 0) {
      ++mask_size[m];
      ++mask_pixels;
    }
    if (f > 0 && m > 0) ++common[{m, f}];
  }
  Score s;
  s.found = found_size.size();
  s.masks = mask_size.size();
  const double all = std::max<std::size_t>(1, found.ids.size());
  s.found_area = found_pixels / all;
  s.mask_area = mask_pixels / all;
  std::map<std::int32_t, bool> used_mask, used_found;
  for (const auto& [pair, shared] : common) {
    const auto [m, f] = pair;
    const double overlap = static_cast<double>(shared) / (mask_size[m] + found_size[f] - shared);
    if (overlap < 0.5 || used_mask[m] || used_found[f]) continue;
    used_mask[m] = used_found[f] = true;
    s.matches.push_back({f, m, overlap});
  }
  return s;
}

}  // namespace terrazzo::instance_score
