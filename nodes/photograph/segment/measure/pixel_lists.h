// The pixels of each label of one section.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace terrazzo::segment {

class PixelLists {
 public:
  explicit PixelLists(std::span<const std::int32_t> ids) {
    std::int32_t low = 0x7fffffff, high = 0;
    for (const std::int32_t id : ids)
      if (id > 0) {
        low = std::min(low, id);
        high = std::max(high, id);
      }
    if (high == 0) low = 1;
    first_.assign(static_cast<std::size_t>(high - low) + 2, 0);
    for (const std::int32_t id : ids)
      if (id >= low) ++first_[id - low + 1];
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    pixels_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (ids[i] >= low) pixels_[next[ids[i] - low]++] = static_cast<std::int32_t>(i);
  }

  std::size_t count() const { return first_.size() - 1; }  // labels, from the lowest to the highest
  // The pixels of the label at `k` above the lowest, in their order; none if no pixel has it.
  std::span<const std::int32_t> of(std::size_t k) const {
    return {pixels_.data() + first_[k], first_[k + 1] - first_[k]};
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::int32_t> pixels_;
};

}  // namespace terrazzo::segment
