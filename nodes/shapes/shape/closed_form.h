// Exact measures of solids with closed forms, to verify tessellations and to replace their measures.
#pragma once

#include <optional>

#include "nodes/data/linear.h"
#include "nodes/shapes/shape/solid_kind.h"

namespace terrazzo::shape {

// Measures of a solid; fields without an implemented closed form are empty. `extents` are the edges of
// its bounding box, mm.
struct ClosedForm {
  std::optional<double> volume;            // mm³
  std::optional<double> surface_area;      // mm²
  std::optional<double> mean_caliper;      // mm
  std::optional<double> max_section_area;  // mm²
};

ClosedForm sphere_closed_form(double diameter);
// Mean caliper 2·R_G(a², b², c²) of the semi-axes.
ClosedForm ellipsoid_closed_form(const Vec3& extents);
ClosedForm box_closed_form(const Vec3& extents);
// Upright elliptic cylinder; mean caliper and surface area only if its section is a circle.
ClosedForm cylinder_closed_form(const Vec3& extents);
// Only the volume: 2abc·ε₁ε₂·B(ε₁/2 + 1, ε₁)·B(ε₂/2, ε₂/2) of the semi-axes (Jaklič, Leonardis,
// Solina 2000, eq. 2.60).
ClosedForm superquadric_closed_form(const Vec3& extents, double e1, double e2);
// Tetrahedron, Octahedron, Dodecahedron or Icosahedron, regular, with the given edge, mm.
ClosedForm platonic_closed_form(SolidKind, double edge);

// Carlson's symmetric elliptic integral R_G: the mean over all directions u of √(x u₁² + y u₂² +
// z u₃²). Arguments ≥ 0, at most one of them zero. Carlson (1995), "Numerical computation of real
// or complex elliptic integrals".
double carlson_rg(double x, double y, double z);

}  // namespace terrazzo::shape
