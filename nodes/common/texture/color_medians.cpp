#include "nodes/common/texture/color_medians.h"

#include <utility>

#include "nodes/common/geometry/rank.h"

namespace terrazzo {
namespace {
constexpr std::int64_t kMost = 500;
}

ColorMedians::ColorMedians(std::vector<std::int64_t> pixels)
    : pixels_(std::move(pixels)), seen_(pixels_.size(), 0), some_(pixels_.size()) {}

void ColorMedians::add(std::size_t label, const Vec3f& color) {
  const std::int64_t all = pixels_[label], n = seen_[label]++;
  // Pixel n of `all` counts if it is the first one of one of kMost equal parts.
  if (all <= kMost || n * kMost % all < kMost) some_[label].push_back(color);
}

Vec3f ColorMedians::value(std::size_t label) const {
  Vec3f out = Vec3f::Zero();
  const std::vector<Vec3f>& some = some_[label];
  if (some.empty()) return out;
  std::vector<float> v(some.size());
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = some[i][c];
    out[c] = at_rank(v, v.size() / 2);
  }
  return out;
}

}  // namespace terrazzo
