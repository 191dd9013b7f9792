// A picture of phases: which phase each pixel shows.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/labels.h"

namespace terrazzo::media {

constexpr std::uint8_t kUnobserved = 255;  // a pixel whose phase nobody knows, such as one under a scale bar
constexpr int kMostPhases = 8;

struct PhaseMap {
  int width = 0, height = 0;
  int phases = 0;
  double pixel_size = 1;         // mm
  std::vector<std::uint8_t> at;  // rows from the top; a phase below `phases`, or kUnobserved

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

// Share of each phase among the observed pixels.
std::vector<double> fractions_of(const PhaseMap&);

// Of the first section. A pixel's phase is 0 without a profile, else the class of its profile + 1. Throws
// Error "too-many-phases".
PhaseMap phase_map(const Labels&);

// The same the other way: profile p is everything of phase p. Unobserved pixels become phase 0.
Labels labels_of(const PhaseMap&);

// A rectangle of a map, and the middle of one, at most `side` pixels along each edge.
PhaseMap cut(const PhaseMap&, int left, int top, int width, int height);
PhaseMap middle_of(const PhaseMap&, int side);

}  // namespace terrazzo::media
