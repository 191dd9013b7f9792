// Particles as JSON text, without building a document in memory.
#pragma once

#include <filesystem>

#include "nodes/data/particles.h"

namespace terrazzo {

// Writes the same fields and numbers as the value's description does (`terrazzo show --json`, Export), one
// field per line. Every finite number reads back to the same bits. Formats on all threads. Throws Error
// "write-failed".
void write_particles_json(const std::filesystem::path&, const Particles&);

}  // namespace terrazzo
