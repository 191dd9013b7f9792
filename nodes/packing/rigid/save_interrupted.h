// Saves what a canceled packing had reached in a file for LoadParticles.
#pragma once

#include <functional>

#include "nodes/packing/rigid/packing.h"
#include "runtime/context.h"

namespace terrazzo::packing {

// For PackOptions::interrupted of a node with an input `start`. Keeps references to both.
std::function<void(const InterruptedPacking&)> saving(Context&, const Shapes&);

}  // namespace terrazzo::packing
