// Measures of a packing.
#pragma once

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::anneal {

// Of all particles, voids included; and of the voids alone.
double volume_fraction(const Shapes& shapes, const Particles& particles);
double void_fraction(const Shapes& shapes, const Particles& particles);

// Largest eigenvalue of ⟨(3 u uᵀ − 1)/2⟩ over the particles' longest axes u (of the tensor of inertia): 1
// where all are parallel, about 1/√n where none are related. 0 without particles.
double nematic_order(const Shapes& shapes, const Particles& particles);

// Particles cut per area by planes across x, y and z, per mm²: ΣH/V with H the extents along that axis.
Vec3 sections_per_area(const Shapes& shapes, const Particles& particles, const Work& work = {});

// g(r) of the centres in `bins` rings up to five mean spacings or half the smallest box edge, relative to an
// even spread: columns "r mm", "g". Of more than 20,000 particles every k-th is looked from.
Table pair_correlation(const Particles& particles, int bins, const Work& work = {});

// Requested and achieved particles and volume of each size class: columns "size_low mm", "size_high mm",
// "requested", "achieved", "N_V_requested 1/mm³", "N_V_achieved 1/mm³".
Table size_table(const SizeDistribution& distribution, const std::vector<double>& expected,
                 const std::vector<int>& size_class, const Vec3& box);

}  // namespace terrazzo::anneal
