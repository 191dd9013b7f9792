// Lets the stones near the surface of a bed come to rest. A packing that is cut has stones that nothing
// carries; real ones lie on each other or in soil.
#pragma once

#include <optional>
#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::view {

// The share of its height that a stone on soil lies in it: stones of banks and beds are about half buried.
inline constexpr float kBuried = 0.5f;

// Diameters that a stone may roll. Friction stops real ones too.
inline constexpr float kFarthest = 6;

struct SettleOptions {
  Vec2 picture = Vec2::Zero();  // width and height, mm; its lower left corner is the origin
  double largest = 0;           // mm, diameter of the largest stone's sphere
  double cell = 0;              // mm, edge of the height map's cells; larger where there would be too many
  float level = 0;              // mm; stones whose centers are below it stay
  float deepest = 0;            // mm; no stone falls lower
  std::optional<float> soil;    // mm, height of level soil; nothing: there is none
};

// How far a stone reaches below its center, mm, above 0; `linear`: its rotation times its scale.
float reach_below(const carving::RayScene::Triangles&, const Eigen::Matrix3f& linear);

// The exposure of a stone is the height of its center above the ground at z = 0 over its reach: −1 or less is
// buried, at 1 it lies on the ground. This is the exposure up to which stones must stay so that those above
// the ground cover a share of the picture, 0 to 1; the highest of any stone if all together cover less.
// `exposures`: of each instance. Of the options, only picture, largest and cell count.
float exposure_of_share(const std::vector<carving::RayScene::Triangles>&,
                        const std::vector<carving::RayScene::Instance>&, const std::vector<float>& exposures,
                        SettleOptions, double share, const Work& = {});

// Changes the offsets of the instances, which are rotations times a scale. From the lowest center to the
// highest, each stone falls straight down onto what has settled before, or into soil by kBuried, and rolls
// downhill up to kFarthest of its diameters. It keeps its orientation and never rises. Stones stay that have
// no whole place in the picture and one largest diameter around it. Stones that did not overlap do so at most
// by about a cell afterwards. The result doesn't depend on threads. Throws Error "bad-number" if the picture
// or the largest stone exceeds 1e15 mm.
void settle(const std::vector<carving::RayScene::Triangles>&, std::vector<carving::RayScene::Instance>&,
            const SettleOptions&, const Work& = {});

}  // namespace terrazzo::view
