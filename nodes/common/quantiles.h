// Distributions as tables of quantiles, and the map that gives values another distribution.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/work.h"

namespace terrazzo {

struct Quantiles {
  std::vector<float> at;      // evenly spaced from the 0th to the last, rising
  float least = 0, most = 0;  // extremes; at's ends lie within
  double deviation = 0;       // standard deviation of all values
  double mean = 0;
  float of(double u) const;   // u in 0 … 1, linear between entries
  void widen(double factor);  // about the mean
};

// From values in any order; at most 65,536 of them, evenly picked, are sorted.
Quantiles quantiles_of(const std::vector<float>& values);

// Of the values behind several tables, each with equal weight.
Quantiles mixture(const std::vector<const Quantiles*>&);

// The rising map, piecewise linear on equal bins, that turns the distribution of counted values into a
// target's. Bins reach beyond the target's range by half of it; what lies further out goes to the ends of
// the target's table.
class Remap {
 public:
  static constexpr int kBins = 4096;
  using Counts = std::vector<std::uint32_t>;  // kBins
  struct Bin {
    float value, rise;
  };

  explicit Remap(const Quantiles& target);  // which must live until finish()
  // A finished map, by what low(), scale() and bins() told of it.
  Remap(float low, float scale, std::vector<Bin> bins)
      : target_(nullptr), lo_(low), scale_(scale), base_(std::move(bins)) {}
  void count(const float* values, std::size_t n, Counts& counts) const;
  // The map for these counts; call it once, before the first use.
  void finish(const Counts& counts);
  void apply(float* values, std::size_t n) const;

  // x = (value − low())·scale(), clamped to 0 … kBins − 0.001, goes to value + (x − ⌊x⌋)·rise of bin ⌊x⌋.
  float low() const { return lo_; }
  float scale() const { return scale_; }
  const std::vector<Bin>& bins() const { return base_; }

 private:
  const Quantiles* target_;
  float lo_, scale_;
  std::vector<Bin> base_;
};

// Gives the values the target's distribution. Equal bits for any number of threads.
void match_values(std::vector<float>& values, const Quantiles& target, const Work& work);

}  // namespace terrazzo
