// Effective conductivity of a voxel model: ∇·(k ∇T) = 0.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/properties/homogenize/convergence.h"
#include "nodes/properties/homogenize/phases.h"

namespace terrazzo::homogenize {

// What surrounds the volume. The values are in the order of the parameter's words.
enum class Boundary {
  Periodic,  // the volume repeats
  Fixed,     // two opposite faces have fixed values, and the others are insulated
};

// What a solver found, and how well.
struct Solved {
  Mat3 effective = Mat3::Zero();    // columns of directions that were not solved are zero
  std::array<bool, 3> connected{};  // whether the phases with a value above zero reach across, by axis
  int iterations = 0;               // most of any direction
  double residual = 0;              // largest of any direction
  // Of the first direction solved: the field that drives the flow, less its mean slope, and the magnitude of
  // the flow.
  std::vector<float> potential, flow;
};

// The conductivity tensor of a map whose phases conduct `values`, ≥ 0 and not all zero, along the chosen
// axes. With cell-centered finite volumes and harmonic means at faces. Fixed: the half voxel between the
// outer voxels' centers and the face conducts as they do; only the diagonal is found. Pieces that do not
// reach across carry no flow and are left out. Throws Error "not-converged", "too-large".
Solved conduct(const PhaseMap&, const std::vector<double>& values, Boundary,
               const std::array<bool, 3>& directions, const Accuracy&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::homogenize
