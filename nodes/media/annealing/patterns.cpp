#include "nodes/media/annealing/patterns.h"

#include <utility>

namespace terrazzo::annealing {
namespace {

// The pattern that `pattern` becomes by one of eight rotations and reflections.
int turn(int pattern, int symmetry) {
  int out = 0;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) {
      int r = symmetry & 1 ? 2 - row : row, c = symmetry & 2 ? 2 - column : column;
      if (symmetry & 4) std::swap(r, c);
      out |= (pattern >> (3 * c + r) & 1) << (3 * column + row);
    }
  return out;
}

// Bits of whether three pixels in a column are in the phase, or −1 if one of them is not observed.
int column_bits(const media::PhaseMap& map, int phase, int x, int top, int spacing) {
  int bits = 0;
  for (int row = 0; row < 3; ++row) {
    const std::uint8_t p = map.at[map.index(x, top + (2 - row) * spacing)];
    if (p == media::kUnobserved) return -1;
    bits |= (p == phase) << row;
  }
  return bits;
}

}  // namespace

Frequencies pattern_frequencies(const media::PhaseMap& map, int phase, int spacing, bool turned) {
  Frequencies counts{}, out{};
  double all = 0;
  std::vector<int> columns(map.width);
  for (int y = 0; y + 2 * spacing < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) columns[x] = column_bits(map, phase, x, y, spacing);
    for (int x = 0; x + 2 * spacing < map.width; ++x) {
      const int a = columns[x], b = columns[x + spacing], c = columns[x + 2 * spacing];
      if ((a | b | c) < 0) continue;
      ++counts[a | b << 3 | c << 6];
      ++all;
    }
  }
  if (all == 0) return out;
  const int symmetries = turned ? 8 : 1;
  for (int k = 0; k < kPatterns; ++k)
    for (int s = 0; s < symmetries; ++s) out[turn(k, s)] += counts[k] / (all * symmetries);
  return out;
}

}  // namespace terrazzo::annealing
