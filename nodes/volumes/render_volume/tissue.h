// Tissues by density: the piecewise constant transfer function (Laursen et al. 2011, section 6).
#pragma once

#include <string>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::render_volume {

enum class Finish { Plain, Texture, Noise };

struct Tissue {
  std::string name;
  double low = 0, high = 0;  // half-open range of densities, Hounsfield units in a scan
  Vec3f color = Vec3f::Constant(0.5f);
  Finish finish = Finish::Plain;
  double opacity = -1;      // per reference step; negative: by density, max(0.3, int + 0.25)
  double penetration = -1;  // mm on which the lamp's light falls to 1/e; negative: that of the scene
};

// Parses "muscle -30 150 #8f3a36 texture": name, range, and in any order a color, `texture` or `noise`,
// `opacity=0.25` and `penetration=3`. Returns the tissues in order of their ranges. Throws Error "bad-class",
// "overlapping-classes", "no-classes" for the parameter `classes`.
std::vector<Tissue> parse_tissues(const std::vector<std::string>&);

// The density axis, split at all bounds of tissues: interval k holds densities in [edge k − 1, edge k).
struct DensityIntervals {
  std::vector<float> edges;
  std::vector<int> tissue;  // per interval, one more than edges; −1 where nothing is visible
};
DensityIntervals intervals_of(const std::vector<Tissue>&);

}  // namespace terrazzo::render_volume
