// Checks before any work: packings that cannot exist, and those that do not fit into memory.
#pragma once

#include "nodes/packing/rigid/population/population.h"
#include "runtime/memory.h"

namespace terrazzo::packing {

// Upper bound of the bytes that packing needs, from experience: few for spheres, which store no contacts.
double memory_needed(const Population& population, const Shapes& shapes);

// Throws Error "impossible-density" if the inscribed balls of the particles, reduced to one size, would be
// denser than balls of one size can be (π/√18, Hales 2005).
void refuse_impossible_density(const Population& population, const Shapes& shapes, double binder_gap);

// Throws Error "not-enough-memory" if more than 90 % of `available` bytes are needed.
void refuse_what_memory_cannot_hold(const Population& population, const Shapes& shapes,
                                    std::uint64_t available = available_memory());

}  // namespace terrazzo::packing
