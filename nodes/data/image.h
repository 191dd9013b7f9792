// Image: one section or a stack of sections of equal scale, scene-linear Rec. 709.
#pragma once

#include <optional>
#include <vector>

#include "nodes/data/georeference.h"
#include "nodes/data/indices.h"
#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Image {
  int width = 0, height = 0, sections = 1;   // pixels, pixels, count; all sections have the same size
  double pixel_size = 1;                     // mm per pixel
  std::vector<Vec3f> pixels;                 // ordered by section, row from the top, column
  std::optional<Georeference> georeference;  // of an image with one section

  Image() = default;
  Image(int width, int height, int sections, double pixel_size, Vec3f fill = Vec3f::Zero())
      : width(width),
        height(height),
        sections(sections),
        pixel_size(pixel_size),
        pixels(pixels_in(width, height) * sections, fill) {}

  std::size_t index(int x, int y, int section = 0) const {
    return (static_cast<std::size_t>(section) * height + y) * width + x;
  }
  Vec3f& at(int x, int y, int section = 0) { return pixels[index(x, y, section)]; }
  const Vec3f& at(int x, int y, int section = 0) const { return pixels[index(x, y, section)]; }
};

template <>
const ValueType& value_type<Image>();

}  // namespace terrazzo
