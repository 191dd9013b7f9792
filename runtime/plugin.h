// Plugins: node types built outside the program. A plugin is a shared library that contains exactly one
//
//   TERRAZZO_PLUGIN(registry, types) { registry.add(my_node()); types.add(value_type<MyValue>()); }
//
// TERRAZZO_PLUGIN_PATH is a colon-separated list of plugin files and of folders, whose *.so files are all
// loaded.
#pragma once

#include <filesystem>
#include <string>

#include "graph/diagnostic.h"
#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo {

// Raise it whenever the layout of types in the headers that plugins include changes.
inline constexpr int kPluginInterface = 3;

// Loads all plugins in the list. Plugins that fail to load are reported and skipped.
Diagnostics load_plugins(const std::string& path_list, Registry&, ValueTypes&);

// The folder of the library that contains this function, which also contains the program's other libraries.
std::filesystem::path library_folder();

}  // namespace terrazzo

#define TERRAZZO_PLUGIN(registry, types)                                            \
  extern "C" int terrazzo_plugin_interface() { return terrazzo::kPluginInterface; } \
  extern "C" void terrazzo_plugin([[maybe_unused]] terrazzo::Registry& registry,    \
                                  [[maybe_unused]] terrazzo::ValueTypes& types)
