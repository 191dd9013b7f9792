// How many stones of a surface are seen from above, and how large they look: what the K matrix is for a cut.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace terrazzo::unfolding {

// What stones lie in. A section has no bed.
enum class Bed { None, Soil, Loose };

// Relative error, as a standard deviation, with which the law below holds for the stones of one size that
// Segment finds in a picture of one bed (results, Views).
inline constexpr double kHidingError = 0.15;

// How small a stone that is seen nearly whole may look, relative to its size.
inline constexpr double kSmallestWhole = 0.8;

// Stones whose height is `height` times their size when they lie flat. N_V of them per volume are seen
// N_V·depth times per area: one layer stands for a depth in proportion to their height, as in Kellerhals and
// Bray (1971), by whom counts per area times D² are shares of volume. Sizes seen are those of completed
// silhouettes (silhouette.h).
//
// In soil, stones lie flat and are seen whole. Loose ones lean, half way between flat and any direction; in a
// layer, Segment finds 0.85 nearly whole, and up to 1.31 parts of deeper ones, most of them small. Both
// numbers are the same for stones of all sizes. Measured on ten beds of balls, pebbles and rocks with sizes
// in ratios up to 6 that fell one after another (results, Views).
class Hiding {
 public:
  Hiding(Bed, double height);

  // Silhouettes of stones of `size` that look larger than `seen`, per area and N_V, mm.
  double above(double size, double seen) const;
  // Rows: classes of sizes seen. Columns: stones with sizes uniform within the classes of `size_edges`.
  // N_A = matrix (mm) · N_V.
  Eigen::MatrixXd matrix(const std::vector<double>& profile_edges,
                         const std::vector<double>& size_edges) const;

 private:
  Bed bed_;
  double depth_;      // of a layer, relative to the size
  double narrowest_;  // mean silhouette in any direction, as a size, relative to that of a stone lying flat
};

}  // namespace terrazzo::unfolding
