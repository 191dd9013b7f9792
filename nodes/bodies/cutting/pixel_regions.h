// Connected regions of equal value in a stack of images, as labels and profiles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/bodies/cutting/section.h"

namespace terrazzo::section {

class PixelRegions {
 public:
  PixelRegions(const SectionLayout& layout, const Image& image)
      : layout_(layout), image_(image), values_(image.pixels.size(), -1) {}

  std::int32_t& value(int x, int row, int section) {
    return values_[image_.index(x, row, section)];
  }  // −1: binder

  // Fills labels, profiles and table. Regions are 4-connected, also across the edges of a tile. `classes`:
  // values are classes, else particles.
  void measure(Section& out, bool classes, const Work& = {}) const;

 private:
  const SectionLayout& layout_;
  const Image& image_;
  std::vector<std::int32_t> values_;
};

}  // namespace terrazzo::section
