// A particle that grows between planes: how large it becomes, and the mesh that the planes leave of it.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/packing/cells/convex_cell.h"

namespace terrazzo::tessellation {

struct GrowingBody {
  Mesh mesh;                   // as packed, rotated, about the position
  std::vector<Vec3> outposts;  // its farthest vertices along many directions
  std::vector<double> wedges;  // six times the signed volume of each triangle's tetrahedron with the center
  double radius = 0;           // bounding radius as packed, mm
  double reach = 0;            // no point may be farther from the center, mm
  double wanted = 0;           // mm³
  double growth = 1;           // factor
  double pressure = 0;         // moves its planes outward, in squared radii
  std::vector<Plane> planes;   // in the order of contacts
  std::vector<Plane> nearest;  // the same, nearest first
  double power = 0;            // of the norm that rounds edges between planes; 0: sharp
  double no_edge = 0;          // planes no farther along than this share of the farthest make no edge
  double alone = 1;            // the least share of the farthest plane in a norm of 1
  double work = 0;             // effort so far

  void set_power(double value);
  void sort_planes();  // sets `nearest`
};

// For each vertex the largest factor of growth at which it is still inside all planes.
std::vector<double> limits_of(GrowingBody&);

// Sets the factor at which the body has its volume, or the largest one. Returns the volume.
double solve_growth(GrowingBody&, const std::vector<double>& limits);

struct GrownSurface {
  double flat = 0, all = 0;  // area in contact with neighbors and in total, before edges are rounded, mm²
};

// An enlarged body between its planes.
struct CutBody {
  Mesh mesh;
  std::vector<Vec3> sharp;    // the vertices before edges were rounded
  std::vector<Plane> planes;  // those that limit it
};

// Cuts the body so that its mesh has the wanted volume. `reached`: whether solve_growth() found a factor.
// `repeats`: how often the volume of the mesh may be corrected.
CutBody cut_to_volume(GrowingBody&, bool reached, int repeats);
GrownSurface surface_of(const CutBody&, const GrowingBody&);

}  // namespace terrazzo::tessellation
