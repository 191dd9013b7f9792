// How far stones stick out of soil.
#pragma once

#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::view {

struct SoilOptions {
  Vec2 picture = Vec2::Zero();  // width and height, mm; its lower left corner is the origin
  double cell = 0;  // mm, edge of the cells that are counted; larger where there would be too many
};

// How far a stone reaches below its center, mm, above 0; `linear`: its rotation times its scale.
float reach_below(const carving::RayScene::Triangles&, const Eigen::Matrix3f& linear);

// The exposure of a stone is the height of its center above the ground at z = 0 over its reach: −1 or less is
// buried, at 1 it lies on the ground. This is the exposure up to which stones must stay so that those above
// the ground cover a share of the picture, 0 to 1; the highest of any stone if all together cover less.
// `exposures`: of each instance. Throws Error "bad-number" if the picture exceeds 1e15 mm.
float exposure_of_share(const std::vector<carving::RayScene::Triangles>&,
                        const std::vector<carving::RayScene::Instance>&, const std::vector<float>& exposures,
                        const SoilOptions&, double share, const Work& = {});

}  // namespace terrazzo::view
