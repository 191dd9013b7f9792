// Particles, alone or with their shapes, as JSON text, without building a document in memory.
#pragma once

#include <filesystem>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

// Writes the same fields and numbers as the value's description does (`terrazzo show --json`, Export), one
// field per line. Every finite number reads back to the same bits. Formats on all threads. Throws Error
// "write-failed".
void write_particles_json(const std::filesystem::path&, const Particles&);

// Writes an object with the fields `particles`, as above, and `shapes`, which LoadParticles and LoadShapes
// read.
void write_packing_json(const std::filesystem::path&, const Particles&, const Shapes&);

}  // namespace terrazzo
