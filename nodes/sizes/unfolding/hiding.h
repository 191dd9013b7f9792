// How many stones of a bed are seen from above, and how large they look: what the K matrix is for a cut.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace terrazzo::unfolding {

// Relative error, as a standard deviation, with which the law below holds for the stones of one size that
// Segment finds in a picture of one bed (results, Views).
inline constexpr double kHidingError = 0.15;

// A ball of size D and density N_V is seen about N_V·D times per area: one layer stands for a depth of D, as
// in Kellerhals and Bray (1971), by whom counts per area times D² are shares of volume. Of flat stones, one
// layer is as deep as they are high (model.h). Most are seen nearly
// whole, the others in parts. How many parts depends on the share g of the bed's volume in coarser stones,
// since only a stone of its size or more hides much of another: (0.92 + 0.35·g)·N_V·D whole ones and
// 1.15·(1 − e^(−4g))·N_V·D parts. Measured on settled beds of spheres of one to five sizes with ratios up to
// 4, whose silhouettes were completed by whole_silhouette() (results, Views).
class Hiding {
 public:
  // As if half of the volume were coarser than any stone.
  Hiding() = default;
  // `volume`: of the stones in the classes between `edges`, mm; sizes are uniform within a class.
  Hiding(std::vector<double> edges, const Eigen::VectorXd& volume);

  // Share of the volume in stones larger than `size`.
  double coarser(double size) const;
  // Balls of `size` whose silhouette looks larger than `seen`, per area and N_V, mm.
  double seen_above(double size, double seen) const;
  // Of balls. Rows: classes of sizes seen. Columns: stones with sizes uniform within the classes of
  // `size_edges`. N_A = matrix (mm) · N_V.
  Eigen::MatrixXd matrix(const std::vector<double>& profile_edges,
                         const std::vector<double>& size_edges) const;

 private:
  std::vector<double> edges_;
  std::vector<double> above_;  // share of the volume above each edge
};

}  // namespace terrazzo::unfolding
