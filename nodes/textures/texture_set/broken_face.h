// The rough face along which a binder breaks.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::texture_set {

// A periodic self-affine surface: its waves have the power k^(−2 − 2 · 0.8), with the roughness exponent 0.8
// of fractures (Bouchaud, Lapasset and Planès 1990), up to a wavelength of four grains, and random phases.
class BrokenFace {
 public:
  // Of one period of width × height mm, for texels of this size (mm), of standard deviation `deviation` (mm).
  // Smaller texels add finer waves. The others keep their phases, and lose the share of the deviation that
  // the finer ones have.
  BrokenFace(double width, double height, double texel, double grain, double deviation, std::uint64_t seed,
             const Work& = {});
  double at(double u, double v) const;  // mm
  double highest() const { return highest_; }
  double lowest() const { return lowest_; }

 private:
  int columns_, rows_;
  double width_, height_, highest_ = 0, lowest_ = 0;
  std::vector<float> mm_;  // on a grid, rows upwards
};

}  // namespace terrazzo::texture_set
