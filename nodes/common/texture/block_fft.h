// Fourier transforms of blocks of voxels.
#pragma once

#include <complex>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {

// Transforms a block of `size` numbers, x fastest, along every axis, in place and unnormalized: a forward and
// an inverse transform together multiply by the number of voxels. The time grows with the largest prime
// factor of the sizes. Equal bits on any number of threads.
void transform_block(std::vector<std::complex<float>>& data, const Vec3i& size, bool inverse, const Work&);

}  // namespace terrazzo
