// How sure a value is that comes from one photograph.
#pragma once

#include <vector>

namespace terrazzo::property_interval {

struct Interval {
  double estimate = 0;  // mean over blocks
  double low = 0, high = 0;
  double photograph = 0;  // standard deviation from what the photograph does not show
  double block = 0;       // standard deviation from one block to another
  double voxels = 0;      // error of the voxels
};

// `blocks`: values of blocks that differ by their seeds; `draws`: values of blocks, one for each draw of
// profiles; `voxel_error`: absolute. Variances of draws contain that of blocks, which is subtracted. The
// interval is that of Student's t for the variance of the estimate, at least that of the mean over blocks,
// and the voxel error adds in squares. Degrees of freedom after Welch 1947. `confidence`:
// 0.5 to 0.999. Throws Error "too-few-values" below two of each.
Interval interval_of(const std::vector<double>& blocks, const std::vector<double>& draws, double voxel_error,
                     double confidence);

// The value that Student's t with this many degrees of freedom exceeds with probability 1 − p; p from 0.5
// to 1.
double student_quantile(double p, double freedom);

}  // namespace terrazzo::property_interval
