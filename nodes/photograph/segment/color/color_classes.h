// Classes of profiles by color.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// The class of each profile, from 0, the most frequent first, by k-means of their colors in Oklab. With
// k = 0, the number of clusters follows from their silhouette; clusters are then joined until any two of
// them differ in the sizes or the circularities of their profiles (Kolmogorov–Smirnov tests, p < 0.001) and
// each has at least 30 complete profiles. Colors that tell nothing about the particles thus make no classes
// of their own.
std::vector<int> color_classes(const Profiles&, int k, std::uint64_t seed, const Work&);

// Significance of the largest distance between the distribution functions of two samples, sorted by size:
// the probability that two samples of one continuous distribution differ more (Kolmogorov–Smirnov, with
// Stephens' approximation of 1970). 1 if a sample is empty.
double kolmogorov_smirnov(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace terrazzo::segment
