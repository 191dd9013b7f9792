// The region that defines a nib's texture, and checks of the strokes.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/strokes.h"

namespace terrazzo::texture_nib {

// Makes a mask with one entry per pixel. Four numbers are x, y, width and height of a rectangle; six or more
// are corners of a polygon, x and y in turn. Throws Error "bad-region", "outside-image".
std::vector<std::uint8_t> region_mask(const std::vector<double>& numbers, int width, int height);

// The picture without the pixels that the strokes cover and `margin` pixels around them.
std::vector<std::uint8_t> region_around(const Strokes&, int width, int height, int margin);

// Throws Error "nib-too-large" if a stroke's nib is larger than the picture, "outside-image" if it covers no
// pixel, "bad-stroke". `number` is the stroke's number in messages, counted from 1.
void check_on_picture(const Stroke&, std::size_t number, int width, int height);

// Numbers of a mask's pixels, row by row.
std::vector<std::uint32_t> pixels_of(const std::vector<std::uint8_t>& mask);

}  // namespace terrazzo::texture_nib
