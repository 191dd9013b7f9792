// Computes a KMatrix from shapes.
#pragma once

#include <string>

#include "nodes/common/gl/egl_context.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::kmatrix {

enum class Method {
  Slice,     // cuts the mesh in quasi-random directions
  Analytic,  // closed form, for ellipsoids
  Stencil    // renders sections
};

struct KMatrixOptions {
  Method method = Method::Slice;
  int classes = 10;  // equal classes of √(A/A_max)
  // Sizes within a column's class: "uniform", or "upper_edge" (Jagnow et al. 2004, eq. 3).
  std::string averaging = "uniform";
  // Directions of `slice`, of which more than 24 shapes share those of 24; 0: until no class changes by more
  // than 0.1 % (see slice_statistics). Planes of `stencil`, 0: 16384.
  std::size_t orientations = 0;
  GlDevice device = GlDevice::Cpu;  // of `stencil`
};

// `orientations_used` receives the largest number of directions used for any shape (0 for `analytic`).
// Throws Error "no-shapes", "bad-probabilities", "unmeasured-shape", "not-an-ellipsoid", "no-gl".
KMatrix make_kmatrix(const Shapes&, const KMatrixOptions&, const Work& = {},
                     std::size_t* orientations_used = nullptr);

}  // namespace terrazzo::kmatrix
