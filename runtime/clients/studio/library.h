// The functions that the program uses from the studio and node libraries. It loads these libraries only when
// a command needs them: they depend on 100 other shared libraries, and loading those takes longer than many
// commands.
#pragma once

#include <filesystem>
#include <string>

#include "graph/registry.h"
#include "runtime/clients/studio/paint/paint_options.h"
#include "runtime/clients/studio/studio_options.h"
#include "runtime/value.h"

namespace terrazzo::studio {

struct Library {
  void (*register_nodes)(Registry&);
  void (*register_value_types)(ValueTypes&);
  std::string (*read_provenance)(const std::filesystem::path&);
  int (*paint)(const PaintOptions&);                    // returns the exit code
  int (*studio)(const StudioOptions&, const NodeSet&);  // the same
};

// Loads the libraries on the first call. Throws Error "program" if they cannot be loaded.
const Library& library();

}  // namespace terrazzo::studio

// The function that the program looks up by name.
extern "C" const terrazzo::studio::Library* terrazzo_studio_library();
