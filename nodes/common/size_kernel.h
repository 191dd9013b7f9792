// The step between sizes of particles and sizes of their profiles, from a shape's section statistics. Sizes
// are √(4·A_max/π) of a particle and √(4·A/π) of a profile; only their ratios matter here, so any unit of
// length serves.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "nodes/data/kmatrix.h"

namespace terrazzo {

// Knots of a cdf, from 0 to 1: cdf[b] is the share of profiles with √(A/A_max) ≤ (b + 1) / cdf.size(). In
// between, the cdf is taken linear in √(1 − s²), which is exact for spheres. The mean over σ, uniform in [lo,
// hi], of σ·P(√(A/A_max) ≤ x/σ): 0 ≤ lo ≤ hi, x ≥ 0. Exact for that cdf.
double mean_scaled_cdf(const std::vector<double>& cdf, double x, double lo, double hi);

// Share of profiles with √(A/A_max) ≤ s.
double cdf_at(const std::vector<double>& cdf, double s);

// Mean of (A/A_max) over the profiles of one particle.
double mean_relative_area(const std::vector<double>& cdf);

// Rows: profile classes between `profile_edges`; columns: particles of sizes uniform within classes of
// `size_edges` (or all at the class's upper edge). Expected profiles per unit of d_max's mean caliper: N_A =
// H̄(d_max)·matrix·N_V, with d_max = size_edges.back() (Jagnow et al. 2004, eq. 3 and 5).
Eigen::MatrixXd size_kernel(const KMatrix::Entry& shape, const std::vector<double>& profile_edges,
                            const std::vector<double>& size_edges, bool upper_edge);

// n equal classes from 0 to `top`: n + 1 edges.
std::vector<double> equal_edges(int n, double top);

// Mean over sizes uniform in [lo, hi] of size³: a class's mean volume is this times the volume at size 1.
double mean_cube(double lo, double hi);

}  // namespace terrazzo
