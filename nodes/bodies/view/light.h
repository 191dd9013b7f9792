// The light on a bed of stones: a sun of finite size and an overcast sky.
#pragma once

#include <optional>

#include "nodes/data/linear.h"

namespace terrazzo::view {

struct Light {
  double azimuth = 135;       // degrees; where the sun stands: 0 is to the right, 90 is up in the picture
  double elevation = 50;      // degrees above the horizon
  double share = 0.5;         // of the light on level ground in the open that comes from the sun, 0 to 1
  Vec2 slope = Vec2::Zero();  // as Profiles::light
};

// The light that gives a photograph's Profiles::light; nothing: that of a slightly hazy day. The stronger the
// slope, the lower the sun: 60° without a slope, 40° from 0.8 per radius. In the middle of a sphere the
// logarithm of the luminance grows by share · cot(elevation) per radius, so the sun gets the share that makes
// this the slope, between 0.15 (overcast) and 0.8 (clear). `azimuth`, `elevation`: degrees, instead.
Light light_of(const std::optional<Vec2>& slope, std::optional<double> azimuth,
               std::optional<double> elevation);

}  // namespace terrazzo::view
