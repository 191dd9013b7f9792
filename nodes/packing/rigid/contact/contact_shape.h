// A shape as the packer needs it: a distance field that other bodies test, and the surface elements with
// which it tests others. One per shape, shared by all instances; own frame, mm at scale 1.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/packing/rigid/contact/distance_field.h"
#include "nodes/packing/rigid/contact/polytope.h"

namespace terrazzo::packing {

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

// Bounding spheres of elements, depth first. After pruning a node, traversal continues at `next`.
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

// The elements to test: a few for early stages, those that flat surfaces touch, or all of them, for contacts
// in dents and where rounded ridges cross.
enum class ContactDetail { Coarse, Fine, All };

struct ContactShape {
  Polytope polytope;  // empty unless convex with few faces
  DistanceField field;
  ElementTree trees[3];  // by ContactDetail; `All` has every vertex
  const ElementTree& tree(ContactDetail d) const { return trees[static_cast<int>(d)]; }
  // Balls inside the body. If bodies are deep in each other, their edges may still be close to the other's
  // surface; only the interior shows how deep they are.
  std::vector<Ball> core;
  // For a sphere, the radius at which another sphere touches it once the corners of its facets are rotated
  // away (turn.h): slightly more than that of the sphere of equal volume. Otherwise 0.
  double ball = 0;
  double bounding_radius = 0;  // about the origin
  double gyration = 0;         // lever arm that weights rotations against translations
  double error = 0;            // typical distance by which field and elements can miss a contact
};

// Elements are placed where the surface protrudes beyond the elements chosen before, so flat parts need none;
// edges sharper than 0.5 rad (29°) are segments. Meshes of thousands of triangles are first simplified,
// within 0.5 % of the diameter of a sphere of equal volume. The mesh must be watertight with its centroid at
// the origin.
ContactShape make_contact_shape(const Mesh& mesh, const Work& work = {});

}  // namespace terrazzo::packing
