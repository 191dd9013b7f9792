#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "tests/bench/gpu/measure.h"

namespace terrazzo::gpu {
namespace {

using kmatrix::SectionStatistics;

double share(const SectionStatistics& s, int k) {
  const auto at = [&](int c) {
    return c == 0 ? 0.0 : s.cdf[static_cast<std::size_t>(c * kmatrix::kSectionBins / 10 - 1)];
  };
  return at(k + 1) - at(k);
}

// The largest difference of a class's share of the profiles.
double largest_error(const SectionStatistics& s, const SectionStatistics& exact) {
  double worst = 0;
  for (int k = 0; k < 10; ++k) worst = std::max(worst, std::abs(share(s, k) - share(exact, k)));
  return worst;
}

}  // namespace

void measure_slices(const Options& o, const Tell& tell) {
  const std::size_t slices = o.quick ? 512 : 102400;
  const Shape body = measure_shape("ellipsoid", shape::ellipsoid_mesh({1, 0.8, 0.6}, 4));
  const SectionStatistics exact = kmatrix::ellipsoid_statistics({0.5, 0.4, 0.3});
  SectionStatistics by_stencil, by_depths;
  kmatrix::stencil_statistics(body, 10, 512, o.device);  // compiles the shaders
  const double stencil =
      median(repeated(o, [&] { by_stencil = kmatrix::stencil_statistics(body, 10, slices, o.device); }));
  const double depths = median(repeated(o, [&] { by_depths = kmatrix::slice_statistics(body, 10, 0); }));
  const double stencil_error = largest_error(by_stencil, exact),
               depths_error = largest_error(by_depths, exact);
  tell(fmt::format("K by stencil: {} slices in {:.3g} s, {:.0f} per second, error {:.2g}; the processor's "
                   "exact depths: "
                   "{:.3g} s, error {:.2g}",
                   slices, stencil, static_cast<double>(slices) / stencil, stencil_error, depths,
                   depths_error),
       {{"kind", "slices"},
        {"slices", slices},
        {"seconds", stencil},
        {"error", stencil_error},
        {"processor_seconds", depths},
        {"processor_error", depths_error}});
}

}  // namespace terrazzo::gpu
