// EBSD maps that tests make: a section through a Voronoi tessellation in 3D whose cells have random
// orientations.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "nodes/photograph/load_ebsd/crystal.h"

namespace terrazzo::test {

struct SampleMap {
  int width = 64, height = 56;
  double step = 0.5;                            // µm
  std::vector<load_ebsd::Symmetry> phases;      // that of a cell is chosen at random
  std::vector<int> cell;                        // of each point
  std::vector<int> phase;                       // of each point, from 0; −1: not indexed
  std::vector<Eigen::Quaternionf> orientation;  // of each point: an equivalent one, with some noise
};

// A uniformly distributed orientation, the same everywhere.
Eigen::Quaternionf random_orientation(std::mt19937&);

// `noise`: largest deviation of a point from its cell's orientation in degrees.
SampleMap sample_map(std::vector<load_ebsd::Symmetry> phases, unsigned seed, int cells = 120,
                     double noise = 0.5, double unindexed = 0.02);

std::string as_ang(const SampleMap&);
std::string as_ctf(const SampleMap&, char point = '.');

}  // namespace terrazzo::test
