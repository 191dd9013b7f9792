// Corrects a distribution so that sections of the packed particles show the profiles that it stands for.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

// Profiles per mm² of an isotropic random section, by size class of the particle (rows) and of the profile
// (columns; sizes √(4·area/π)). Classes are those between `edges`; larger profiles count in the last class.
// Each shape is cut by `sections` random planes, so the estimate's error is that of the sections only.
Eigen::MatrixXd profile_densities(const Shapes& shapes, const Particles& particles,
                                  const std::vector<int>& size_class, const std::vector<double>& edges,
                                  int sections, std::uint64_t seed, const Work& work = {});

// Half the sum of |a − b| after both are divided by their sums: 0 (equal) to 1 (no overlap).
double misfit(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

// The misfit that `profiles` independent profiles of the same distribution have on average.
double sampling_misfit(const Eigen::VectorXd& density, double profiles);

// Multiplies the number density of each class by the mean ratio of wanted to shown profiles over the profiles
// of that class's particles: a step of expectation maximization (Richardson–Lucy). A factor is within ½ … 2.
void correct(SizeDistribution& distribution, const Eigen::VectorXd& wanted, const Eigen::MatrixXd& shown);

}  // namespace terrazzo::tessellation
