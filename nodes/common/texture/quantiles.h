// Distributions as quantile tables, and histogram matching with them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/work.h"

namespace terrazzo {

struct Quantiles {
  std::vector<float> at;      // evenly spaced quantiles from 0 to 1, increasing
  float least = 0, most = 0;  // extremes; the ends of `at` are within them
  double deviation = 0;       // standard deviation of all values
  double mean = 0;
  float of(double u) const;   // u in 0 … 1, linear between entries
  void widen(double factor);  // scales the spread about the mean
};

// The table of values in any order. Sorts at most 65,536 evenly selected values.
Quantiles quantiles_of(const std::vector<float>& values);

// The mixture of several distributions with equal weights.
Quantiles mixture(const std::vector<const Quantiles*>&);

// Histogram matching: the increasing, piecewise linear map on equal bins that turns the distribution of the
// counted values into the target's. The bins extend beyond the target's range by half of it on each side;
// values farther out map to the ends of the target's table.
class Remap {
 public:
  static constexpr int kBins = 4096;
  using Counts = std::vector<std::uint32_t>;  // kBins entries
  struct Bin {
    float value, rise;
  };

  explicit Remap(const Quantiles& target);  // target must live until finish()
  // Restores a finished map from low(), scale() and bins().
  Remap(float low, float scale, std::vector<Bin> bins)
      : target_(nullptr), lo_(low), scale_(scale), base_(std::move(bins)) {}
  void count(const float* values, std::size_t n, Counts& counts) const;
  // Computes the map for these counts. Call it once, before the first use.
  void finish(const Counts& counts);
  void apply(float* values, std::size_t n) const;

  // x = (value − low())·scale(), clamped to 0 … kBins − 0.001, maps to value + (x − ⌊x⌋)·rise of bin ⌊x⌋.
  float low() const { return lo_; }
  float scale() const { return scale_; }
  const std::vector<Bin>& bins() const { return base_; }

 private:
  const Quantiles* target_;
  float lo_, scale_;
  std::vector<Bin> base_;
};

// Matches the histogram of the values to the target's. The result does not depend on the number of threads.
void match_values(std::vector<float>& values, const Quantiles& target, const Work& work);

}  // namespace terrazzo
