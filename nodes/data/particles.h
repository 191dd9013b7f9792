// Particles: instances of shapes in a periodic box [0, L)³.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Particles {
  Vec3 box = Vec3::Zero();             // edge lengths, mm
  std::vector<std::int32_t> shape;     // index into Shapes
  std::vector<std::int32_t> cls;       // color or particle class
  std::vector<Vec3> position;          // of the shape's origin, mm, inside the box
  std::vector<Quat> orientation;       // unit quaternions
  std::vector<double> scale;           // factor of the mesh
  std::vector<double> size;            // √(4·A_max/π), mm
  std::vector<Vec3f> color;            // scene-linear
  Vec3f binder_color = Vec3f::Zero();  // scene-linear
  std::vector<std::uint8_t> voids;     // 1 for each particle that is a void; empty: there are no voids

  std::size_t count() const { return position.size(); }
  bool is_void(std::size_t i) const { return !voids.empty() && voids[i] != 0; }
  std::size_t void_count() const {
    return voids.size() - static_cast<std::size_t>(std::count(voids.begin(), voids.end(), 0));
  }
  void resize(std::size_t n) {
    shape.resize(n);
    cls.resize(n);
    position.resize(n, Vec3::Zero());
    orientation.resize(n, Quat::Identity());
    if (!voids.empty()) voids.resize(n);
    scale.resize(n, 1);
    size.resize(n);
    color.resize(n, Vec3f::Constant(0.5f));
  }
};

template <>
const ValueType& value_type<Particles>();

}  // namespace terrazzo
