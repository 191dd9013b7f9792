// A ball of 10 mm carved from a solid whose color is linear in space.
#pragma once

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/opaque_volume.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

// Scene-linear, at a point relative to the ball's center, mm.
inline Vec3f carved_ball_color(const Vec3& p) {
  return {float(0.5 + 0.05 * p.x()), float(0.5 - 0.06 * p.y()), float(0.5 + 0.03 * p.z())};
}

inline NodeRun carved_ball(const std::string& texture = "256") {
  Volume v;  // 16 mm, with the ball in the middle
  add_vector_grid(v, "Cd", Vec3i::Constant(32), 0.5, {}, [](std::size_t i) {
    return carved_ball_color(
        Vec3(double(i % 32) - 15.5, double(i / 32 % 32) - 15.5, double(i / 1024) - 15.5) * 0.5);
  });
  Shapes body;
  body.shapes = {measure_shape("ball", sphere_mesh(3))};
  body.shapes[0].smooth = true;
  // 10 of 16 mm, and from the corner of the ball's box to the volume's.
  return run_node(
      "Carve", {{"volume", Value::of(std::move(v))}, {"object", Value::of(std::move(body))}},
      {{"repeat", "0.625"}, {"shift", "[0.1875, 0.1875, 0.1875]"}, {"edge", "1"}, {"texture", texture}});
}

}  // namespace terrazzo::test
