// Clusters of small particles, as sections show them.
#pragma once

#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::packing {

// A Thomas process (1949) in the space that larger particles leave: each cluster's particles are normally
// distributed about its center, and centers are random. The pair correlation is then
// 1 + excess · exp(−r² / (4 · spread²)), in space as in a section through particles that are smaller than
// their cluster.
struct Clusters {
  double below = 0;   // mm; smaller particles stand in clusters. 0: none do
  double spread = 0;  // mm; standard deviation of the distances from a cluster's center, along each axis
  double excess = 0;

  double per_volume() const;  // centers, 1/mm³
};

// Compares the distances between small profiles of a section with those of random points outside of the
// larger profiles. The largest size that counts as small is the quantile at which they differ most. None if
// that is within chance, for surfaces, or without outlines.
Clusters measure_clusters(const Profiles&, const Work& work = {});

}  // namespace terrazzo::packing
