// Particles: instances of shapes in a periodic box [0, L)³.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Particles {
  Vec3 box = Vec3::Zero();             // edges, mm
  std::vector<std::int32_t> shape;     // index into Shapes
  std::vector<std::int32_t> cls;       // colour or particle class
  std::vector<Vec3> position;          // of the shape's origin, mm, inside the box
  std::vector<Quat> orientation;       // unit
  std::vector<double> scale;           // of the mesh
  std::vector<double> size;            // √(4·A_max/π), mm
  std::vector<Vec3f> color;            // scene-linear
  Vec3f binder_color = Vec3f::Zero();  // scene-linear

  std::size_t count() const { return position.size(); }
  void resize(std::size_t n) {
    shape.resize(n), cls.resize(n), position.resize(n, Vec3::Zero()), orientation.resize(n, Quat::Identity());
    scale.resize(n, 1), size.resize(n), color.resize(n, Vec3f::Constant(0.5f));
  }
};

template <>
const ValueType& value_type<Particles>();

}  // namespace terrazzo
