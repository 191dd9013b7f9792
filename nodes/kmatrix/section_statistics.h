// How large the random sections of a body are: what K is made of.
#pragma once

#include <vector>

#include "nodes/common/egl_context.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

constexpr int kSectionBins = 1000;  // knots of the cdf of √(A/A_max)

struct SectionStatistics {
  double mean_caliper = 0;          // mm
  double max_section_area = 0;      // mm²
  double volume = 0;                // mm³
  double profiles_per_caliper = 1;  // expected profiles of a random plane that meets the hull
  std::vector<double> cdf;          // as KMatrix::Entry::cdf, kSectionBins long
  double residual = 0;           // largest relative change of a class between half and all of the directions
  std::size_t orientations = 0;  // directions used
};

// Isotropic uniform random sections of any closed mesh: quasi-random directions (an R2 sequence), each
// integrated over all depths exactly (between 97 exact depths where a convex body has a thousand triangles or
// more); disjoint profiles count apart. With `orientations` 0, directions are doubled until no class of
// `classes` equal ones of √(A/A_max) changes by more than 1e-3 relative (4e-3 for those many triangles), at
// most 65536; otherwise as many as asked for.
SectionStatistics slice_statistics(const Shape&, int classes, std::size_t orientations, const Work& = {});

// The same by counting pixels of a stencil buffer (Jagnow et al. 2004, section 3.2), a plane at a time but
// many per draw: quasi-random directions and depths, `slices` of them (0: 16384). Profiles are told apart by
// their pixels, 256 to the body's diameter. Throws Error "no-gl".
SectionStatistics stencil_statistics(const Shape&, int classes, std::size_t slices, GlDevice,
                                     const Work& = {});

// The largest relative change of a class's share between two histograms of kSectionBins.
double largest_change(const std::vector<double>& before, const std::vector<double>& after, int classes);

// Closed form for ellipsoids (spheres and spheroids among them): A₀(u) = πabc/w(u), P(A ≤ t | u) = 1 − √(1 −
// t/A₀), directions by quadrature. Semi-axes, mm, in any order.
SectionStatistics ellipsoid_statistics(const Vec3& semi_axes);

// The semi-axes of the ellipsoid that a mesh is a tessellation of, largest first, scaled to the shape's
// volume: all vertices lie within 0.1 % of it, and it is filled to 90 % or more (which a cube or an
// icosahedron, whose corners lie on a sphere too, are not). Throws Error "not-an-ellipsoid" otherwise.
Vec3 fit_ellipsoid(const Shape&);

}  // namespace terrazzo
