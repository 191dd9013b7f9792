#include "nodes/properties/property_interval/interval.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/statistics/anova.h"

namespace terrazzo::property_interval {
namespace {

struct Moments {
  double mean = 0, variance = 0;
};

Moments moments_of(const std::vector<double>& values, const char* what) {
  if (values.size() < 2)
    throw Error("too-few-values", fmt::format("{} {} show no spread", values.size(), what),
                "connect at least two");
  Moments out;
  const double n = values.size();
  for (const double v : values) out.mean += v / n;
  for (const double v : values) out.variance += (v - out.mean) * (v - out.mean) / (n - 1);
  return out;
}

}  // namespace

double student_quantile(double p, double freedom) {
  // t² has the F distribution with 1 and `freedom` degrees of freedom.
  double low = 0, high = 1;
  const auto above = [&](double t) { return f_tail(t * t, 1, freedom) / 2 > 1 - p; };
  while (above(high)) high *= 2;
  for (int k = 0; k < 100; ++k) (above((low + high) / 2) ? low : high) = (low + high) / 2;
  return high;
}

Interval interval_of(const std::vector<double>& blocks, const std::vector<double>& draws, double voxel_error,
                     double confidence) {
  const Moments block = moments_of(blocks, "blocks"), draw = moments_of(draws, "draws");
  Interval out;
  out.estimate = block.mean;
  out.block = std::sqrt(block.variance);
  out.photograph = std::sqrt(std::max(0.0, draw.variance - block.variance));
  out.voxels = std::abs(voxel_error);
  // What the draws share with the blocks and the mean over blocks does not have.
  const double shared = block.variance * (1 - 1.0 / blocks.size());
  double variance = draw.variance - shared, freedom = 0;
  if (draw.variance > block.variance) {  // Welch and Satterthwaite's degrees of freedom
    freedom =
        variance * variance /
        (draw.variance * draw.variance / (draws.size() - 1.0) + shared * shared / (blocks.size() - 1.0));
  } else {
    variance = block.variance / blocks.size();
    freedom = blocks.size() - 1.0;
  }
  freedom = std::max(1.0, freedom);
  const double half =
      std::hypot(student_quantile((1 + confidence) / 2, freedom) * std::sqrt(variance), out.voxels);
  out.low = out.estimate - half;
  out.high = out.estimate + half;
  return out;
}

}  // namespace terrazzo::property_interval
