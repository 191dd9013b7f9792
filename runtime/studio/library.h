// What the program takes from the libraries of the studio and the nodes. It loads them when a command needs
// them: they bring 270 shared libraries of others, and loading those takes longer than most commands.
#pragma once

#include <filesystem>
#include <string>

#include "graph/registry.h"
#include "runtime/studio/paint_options.h"
#include "runtime/value.h"

namespace terrazzo::studio {

struct Library {
  void (*register_nodes)(Registry&);
  void (*register_value_types)(ValueTypes&);
  std::string (*read_provenance)(const std::filesystem::path&);
  int (*paint)(const PaintOptions&);  // returns the exit code
};

// Loads the libraries on the first call. Throws Error "program" if they cannot be loaded.
const Library& library();

}  // namespace terrazzo::studio

// The one function that the program finds by its name.
extern "C" const terrazzo::studio::Library* terrazzo_studio_library();
