// The region that defines a nib's texture, and what the nib is asked to cover.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/strokes.h"

namespace terrazzo::texture_nib {

// Four numbers: x, y, width, height of a rectangle; six or more: corners of a polygon, x and y in turn. One
// entry a pixel. Throws Error "bad-region", "outside-image".
std::vector<std::uint8_t> region_mask(const std::vector<double>& numbers, int width, int height);

// The picture without what the strokes cover and `margin` pixels around it.
std::vector<std::uint8_t> region_around(const Strokes&, int width, int height, int margin);

// Throws Error "nib-too-large" where a stroke's nib is larger than the picture, "outside-image" where it
// covers none of its pixels, "bad-stroke". `number` counts from 1, for the message.
void check_on_picture(const Stroke&, std::size_t number, int width, int height);

// A mask's pixels as an area, row by row.
std::vector<std::uint32_t> pixels_of(const std::vector<std::uint8_t>& mask);

}  // namespace terrazzo::texture_nib
