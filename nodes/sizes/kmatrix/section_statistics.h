// Statistics of the random sections of a body, from which K is computed.
#pragma once

#include <vector>

#include "nodes/common/gl/egl_context.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::kmatrix {

constexpr int kSectionBins = 1000;  // bins of the cdf of √(A/A_max)

struct SectionStatistics {
  double mean_caliper = 0;          // mm
  double max_section_area = 0;      // mm²
  double volume = 0;                // mm³
  double profiles_per_caliper = 1;  // expected profiles of a random plane that meets the hull
  std::vector<double> cdf;          // as KMatrix::Entry::cdf, kSectionBins long
  double residual = 0;           // largest relative change of a class between half and all of the directions
  std::size_t orientations = 0;  // number of directions used
};

// Isotropic uniform random sections of any closed mesh: quasi-random directions (an R2 sequence), each
// integrated exactly over all depths (between 97 exact depths if a convex body has a thousand triangles or
// more). Disjoint profiles are counted separately. If `orientations` is 0, the number of directions doubles
// until no class of `classes` equal ones of √(A/A_max) changes by more than 1e-3 relative (4e-3 for convex
// bodies of a thousand triangles or more), up to 65536; otherwise it is `orientations`.
SectionStatistics slice_statistics(const Shape&, int classes, std::size_t orientations, const Work& = {});

// The same by counting pixels of a stencil buffer (Jagnow et al. 2004, section 3.2), one plane at a time but
// many per draw: `slices` planes (0: 16384) with quasi-random directions and depths, at 256 pixels per body
// diameter. Connected pixels form a profile. Throws Error "no-gl".
SectionStatistics stencil_statistics(const Shape&, int classes, std::size_t slices, GlDevice,
                                     const Work& = {});

// The largest relative change of a class's share between two histograms of kSectionBins.
double largest_change(const std::vector<double>& before, const std::vector<double>& after, int classes);

// Closed form for ellipsoids, including spheres and spheroids: A₀(u) = πabc/w(u), P(A ≤ t | u) = 1 − √(1 −
// t/A₀), directions by quadrature. Semi-axes in mm, in any order.
SectionStatistics ellipsoid_statistics(const Vec3& semi_axes);

// The semi-axes of the ellipsoid that a mesh tessellates, largest first, scaled to the shape's volume. All
// vertices must lie within 0.1 % of the ellipsoid, and the mesh must fill 90 % of it or more (a cube and an
// icosahedron do not, although their corners lie on a sphere). Otherwise throws Error "not-an-ellipsoid".
Vec3 fit_ellipsoid(const Shape&);

}  // namespace terrazzo::kmatrix
