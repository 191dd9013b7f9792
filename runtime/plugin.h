// Node types built outside the program. A plugin is a shared library that contains, once,
//
//   TERRAZZO_PLUGIN(registry, types) { registry.add(my_node()); types.add(value_type<MyValue>()); }
//
// The program loads it from TERRAZZO_PLUGIN_PATH: folders (every *.so in them) and files, parted by colons.
#pragma once

#include <filesystem>
#include <string>

#include "graph/diagnostic.h"
#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo {

// Raised whenever the headers that plugins see change their layout.
inline constexpr int plugin_interface = 2;

// What could not be loaded is reported, and the rest is loaded.
Diagnostics load_plugins(const std::string& path_list, Registry&, ValueTypes&);

// The folder of the library that this function is in. The program's other libraries lie beside it.
std::filesystem::path library_folder();

}  // namespace terrazzo

#define TERRAZZO_PLUGIN(registry, types)                                            \
  extern "C" int terrazzo_plugin_interface() { return terrazzo::plugin_interface; } \
  extern "C" void terrazzo_plugin([[maybe_unused]] terrazzo::Registry& registry,    \
                                  [[maybe_unused]] terrazzo::ValueTypes& types)
