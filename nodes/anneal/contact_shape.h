// What the packer knows of a shape: a distance field to be probed by others, and the surface elements that it
// probes others with. One per shape, shared by all instances; own frame, mm at scale 1.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/anneal/distance_field.h"
#include "nodes/anneal/polytope.h"

namespace terrazzo::anneal {

// A point, or a segment center ± half.
struct Element {
  float center[3];
  float half[3] = {0, 0, 0};
  float half_length = 0;
};

struct Ball {
  float center[3];
  float radius;
};

// Spheres around elements, depth first: a pruned node continues at `next`.
struct ElementTree {
  struct Node {
    float center[3];
    float radius;
    std::int32_t next;
    std::int32_t first, count;  // elements of a leaf; count 0 in an inner node
  };
  std::vector<Node> nodes;
  std::vector<Element> elements;
};

// Which elements are probed: few for states far from done, those that flat partners touch, or all that there
// are, for partners that touch in dents and where rounded ridges cross.
enum class Detail { Coarse, Fine, All };

struct ContactShape {
  Polytope polytope;  // empty unless convex with few faces
  DistanceField field;
  ElementTree trees[3];  // by Detail; `All` has every vertex
  const ElementTree& tree(Detail d) const { return trees[static_cast<int>(d)]; }
  // Balls within the body. Bodies deep in each other may cross with their edges near each other's surface:
  // only what lies inside tells how deep they are.
  std::vector<Ball> core;
  // Of a sphere, the radius where another sphere touches it, the corners of its facets being turned away
  // (turn.h): little more than that of the sphere of the same volume. 0 of all else.
  double ball = 0;
  double bounding_radius = 0;  // about the origin
  double gyration = 0;         // lever arm that weighs rotations against translations
  double error = 0;            // typical distance by which field and elements may miss a contact
};

// Elements are chosen where the surface protrudes beyond those chosen before, so flat parts need none; edges
// sharper than 30° enter as segments. The mesh must be watertight with its centroid at the origin.
ContactShape make_contact_shape(const Mesh& mesh, const Work& work = {});

}  // namespace terrazzo::anneal
