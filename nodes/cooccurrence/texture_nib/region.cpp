#include "nodes/cooccurrence/texture_nib/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/footprint.h"
#include "nodes/data/indices.h"

namespace terrazzo::texture_nib {
std::vector<std::uint8_t> region_mask(const std::vector<double>& v, int width, int height) {
  if (v.size() < 4 || v.size() % 2 != 0)
    throw Error("bad-region", fmt::format("{} numbers do not describe a region", v.size()),
                "write x, y, width, height, or at least three corners, x and y in turn")
        .parameter("region");
  std::vector<Vec2> corners;
  if (v.size() == 4) {
    if (!(v[2] > 0 && v[3] > 0))
      throw Error("bad-region", fmt::format("the region has {} × {} pixels", v[2], v[3]),
                  "width and height must be above 0")
          .parameter("region");
    corners = {{v[0], v[1]}, {v[0] + v[2], v[1]}, {v[0] + v[2], v[1] + v[3]}, {v[0], v[1] + v[3]}};
  } else {
    for (std::size_t i = 0; i < v.size(); i += 2) corners.emplace_back(v[i], v[i + 1]);
  }
  for (const auto& c : corners)
    if (!(c.x() >= 0 && c.y() >= 0 && c.x() <= width && c.y() <= height))
      throw Error("outside-image",
                  fmt::format("the region extends to ({}, {}), but the picture has {} × {} pixels", c.x(),
                              c.y(), width, height),
                  "draw the region inside the picture")
          .parameter("region");
  std::vector<std::uint8_t> out(pixels_in(width, height), 0);
  for (const auto p : surrounded(width, height, {corners})) out[p] = 1;
  return out;
}

std::vector<std::uint8_t> region_around(const Strokes& strokes, int width, int height, int margin) {
  std::vector<std::uint8_t> out(pixels_in(width, height), 1);
  for (const auto& s : strokes.strokes)
    for (const auto p : footprint_of(s, width, height, margin)) out[p] = 0;
  return out;
}

void check_on_picture(const Stroke& s, std::size_t number, int width, int height) {
  check_stroke(s);
  if (2 * s.radius > std::max(width, height))
    throw Error("nib-too-large",
                fmt::format("the nib of stroke {} has {} pixels across, but the picture has {} × {} pixels",
                            number, 2 * s.radius, width, height),
                "reduce the radius");
  if (footprint_of(s, width, height).empty())
    throw Error("outside-image",
                fmt::format("stroke {} covers no pixel of the picture, which has {} × {} pixels", number,
                            width, height),
                "write points in pixels from the picture's upper left corner");
}

std::vector<std::uint32_t> pixels_of(const std::vector<std::uint8_t>& mask) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i]) out.push_back(i);
  return out;
}

}  // namespace terrazzo::texture_nib
