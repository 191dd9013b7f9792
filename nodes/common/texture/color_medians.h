// The usual color of each label: unlike a mean, specks, pits and cracks do not change it.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo {

// Medians of each channel over at most 500 pixels per label, evenly spread over its pixels in their order.
class ColorMedians {
 public:
  // `pixels`: how many pixels of each label add() will get.
  explicit ColorMedians(std::vector<std::int64_t> pixels);
  void add(std::size_t label, const Vec3f& color);
  // Zero if the label has no pixels. The order of pixels within a label decides which of them count.
  Vec3f value(std::size_t label) const;

 private:
  std::vector<std::int64_t> pixels_, seen_;
  std::vector<std::vector<Vec3f>> some_;
};

}  // namespace terrazzo
