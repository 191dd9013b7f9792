// The kernel from particle sizes to profile sizes, computed from a shape's section statistics. Sizes are
// √(4·A_max/π) of a particle and √(4·A/π) of a profile, in any unit of length, since only their ratios
// matter.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "nodes/data/kmatrix.h"

namespace terrazzo {

// The mean over σ, uniform in [lo, hi], of σ·P(√(A/A_max) ≤ x/σ), with 0 ≤ lo ≤ hi and x ≥ 0. `cdf` contains
// the knots of the cumulative distribution: cdf[b] is the share of profiles with √(A/A_max) ≤ (b + 1) /
// cdf.size(). Between knots it is linear in √(1 − s²), which is exact for spheres. The result is exact for
// this distribution.
double mean_scaled_cdf(const std::vector<double>& cdf, double x, double lo, double hi);

// Share of profiles with √(A/A_max) ≤ s.
double cdf_at(const std::vector<double>& cdf, double s);

// Mean of A/A_max over the profiles of one particle.
double mean_relative_area(const std::vector<double>& cdf);

// Rows: profile classes with edges `profile_edges`. Columns: particles with sizes uniform within the classes
// of `size_edges`, or at the class's upper edge. Entries: expected number of profiles per unit of the mean
// caliper diameter at size d_max: N_A = H̄(d_max)·matrix·N_V, with d_max = size_edges.back() (Jagnow et al.
// 2004, eq. 3 and 5).
Eigen::MatrixXd size_kernel(const KMatrix::Entry& shape, const std::vector<double>& profile_edges,
                            const std::vector<double>& size_edges, bool upper_edge);

// The n + 1 edges of n equal classes from 0 to `top`.
std::vector<double> equal_edges(int n, double top);

// Mean of size³ over sizes uniform in [lo, hi]. Times the volume at size 1, it is the mean volume of a class.
double mean_cube(double lo, double hi);

}  // namespace terrazzo
