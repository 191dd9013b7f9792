// The Euler characteristic of a closed triangle mesh.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo::test {

inline int euler(const Mesh& m) {
  return static_cast<int>(m.vertices.size()) - static_cast<int>(m.triangles.size()) / 2;
}

}  // namespace terrazzo::test
