// Measures of a packing.
#pragma once

#include <cstddef>
#include <utility>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::packing {

// Volume fraction of all particles, including voids; volume fraction of only the voids.
double volume_fraction(const Shapes& shapes, const Particles& particles);
double void_fraction(const Shapes& shapes, const Particles& particles);

// Lowest and highest z of a particle, mm.
std::pair<double, double> height_range(const Shapes& shapes, const Particles& particles, std::size_t i);

// Largest eigenvalue of ⟨(3 u uᵀ − 1)/2⟩ over the particles' longest axes u (of the second moments of the
// surface): 1 if all are parallel, about 1/√n if they are independent. 0 without particles.
double nematic_order(const Shapes& shapes, const Particles& particles);

// Particles per mm² cut by planes perpendicular to x, y and z: ΣH/V, where H is the extent along that axis.
Vec3 sections_per_area(const Shapes& shapes, const Particles& particles, const Work& work = {});

// g(r) of the centers in `bins` shells up to five mean spacings or half the smallest box edge,
// relative to a uniform distribution: columns "r mm", "g". With more than 20,000 particles only every
// k-th is a starting point.
Table pair_correlation(const Particles& particles, int bins, const Work& work = {});

// Requested and achieved particles of each size class, and their number densities: columns "size_low mm",
// "size_high mm", "requested", "achieved", "N_V_requested 1/mm³", "N_V_achieved 1/mm³".
Table size_table(const SizeDistribution& distribution, const std::vector<double>& expected,
                 const std::vector<int>& size_class, const Vec3& box);

}  // namespace terrazzo::packing
