// What can be told before any work: packings that cannot exist, and those that do not fit into memory.
#pragma once

#include "nodes/anneal/population.h"
#include "runtime/memory.h"

namespace terrazzo::anneal {

// Bytes that packing takes at most, by experience: few for spheres, which need no contacts.
double memory_needed(const Population& population, const Shapes& shapes);

// Throws Error "impossible-density" where the balls inside the particles, taken down to one size, would be
// denser than balls of one size can be (π/√18, Hales 2005), and "not-enough-memory" where more is needed than
// `available`.
void refuse_what_cannot_be(const Population& population, const Shapes& shapes, double binder_gap,
                           std::uint64_t available = available_memory());

}  // namespace terrazzo::anneal
