// How strong noise is, and whether it is a camera's.
#pragma once

#include <array>
#include <vector>

#include "nodes/detail/detail_solid/noise_plane.h"

namespace terrazzo::detail_solid {

constexpr std::size_t kLeastAtLevel = 40;  // blocks at a level that is measured

// The noise's variance in each coefficient of a block, by lightness: at[level] · spectrum.
struct Strength {
  Block spectrum = Block::Zero();
  std::array<float, kLightness> at{};
  bool of_a_camera = false;  // even, fine, and alike at all lightnesses (noise.h)
};

// Of each channel.
std::array<Strength, 3> strengths_of(const std::vector<Plane>&, const Work& = {});

// Levels without a value take those of the nearest ones, between two linearly.
void fill_levels(std::array<float, kLightness>& at, const std::array<bool, kLightness>& known);

}  // namespace terrazzo::detail_solid
