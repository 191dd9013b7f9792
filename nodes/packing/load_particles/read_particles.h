// Reads particles from JSON, as Export, `terrazzo show --json` and interrupted packings write it.
#pragma once

#include <string>

#include "nodes/data/particles.h"

namespace terrazzo::load_particles {

// The fields are those of `terrazzo show --json`: box (mm), shape (≥ 0), position (in the box, mm),
// orientation (w, x, y, z; length 1 within 1e-6), scale (> 0), size (> 0, mm), and optionally class (≥ 0,
// default 0), color and binder_color (scene-linear, default gray 0.5 and black), voids (ascending indices)
// and count. Other fields are ignored. The object may also be the field `particles` of another one, as Export
// writes it for several inputs. Numbers are read to the last bit. `file` is used in messages only. Memory is
// proportional to the text, and nesting costs none. Throws Error "unreadable-file" if the text has another
// structure, "bad-particles" if a field is missing or the lists differ in length, "bad-box", "bad-particle".
Particles read_particles(const std::string& text, const std::string& file);

// Upper bound of the bytes that read_particles needs, including the text.
double memory_to_read(const std::string& text);

}  // namespace terrazzo::load_particles
