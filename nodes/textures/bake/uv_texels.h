// Which triangle of a mesh each texel shows, and where in space the texel lies.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::bake {

struct UvTexels {
  int size = 0;                        // texels along an edge of the square texture
  std::vector<std::int32_t> triangle;  // of each texel, row by row from the top; −1: none
  std::size_t covered = 0;             // texels whose center lies in a triangle
  std::size_t overlapping = 0;         // of these, those in several triangles; the first one has them
  // Triangles that cover nothing, in space or in the texture, where heights below 1 / 256 texel are rounding.
  std::size_t without_area = 0;
  std::size_t outside = 0;  // triangles that leave the texture and enter it at the opposite edge
};

// Triangles that share an edge share no texel. Texels up to `padding` away from a triangle belong to it, too,
// so that filters across a seam find its colors. Throws Error "bad-uv" for coordinates beyond ±64, if the
// triangles cover the texture more than 64 times, or if they are slivers with more than 2³⁰ rows of texels,
// "bad-mesh" if no triangle covers anything.
UvTexels find_texels(const Mesh&, const std::vector<CornerUv>&, int size, int padding, const Work& = {});

// Gives each texel of no triangle the value of the nearest one that has a triangle, in steps to any of the
// eight neighbors, also across the texture's edges, which join in a height field.
void extend_to_blanks(const UvTexels&, std::vector<float>& values, const Work& = {});

// Where texels lie in space: triangles as planes.
class TexelPlaces {
 public:
  // `scale`: mm of the solid per mm of the mesh.
  TexelPlaces(const Mesh&, const std::vector<CornerUv>&, int size, double scale, const Work& = {});

  struct Axes {
    Vec3 right, down;  // mm per texel
    Vec3 normal;       // unit length, outwards
  };
  // mm, at (right, down) from the texel's upper left corner, both 0 to 1. Continues the triangle's plane.
  Vec3 at(std::int32_t triangle, int x, int y, double right, double down) const;
  Axes axes(std::int32_t triangle) const;

 private:
  struct Plane {
    Vec3 origin;             // mm, of the texture's upper left corner
    Vec3 right, down;        // mm per texel
    Eigen::Vector2d q[3];    // corners, texels
    Eigen::Vector2i lo, hi;  // tiles of the texture that the triangle reaches
  };
  Eigen::Vector2i tile(const Plane&, const Eigen::Vector2d& texel) const;

  int size_;
  std::vector<Plane> planes_;
  std::vector<Vec3> normal_;
};

}  // namespace terrazzo::bake
