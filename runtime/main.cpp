#include <cstdlib>
#include <iostream>

#include "nodes/common/provenance.h"
#include "nodes/register_nodes.h"
#include "runtime/cli/command_line.h"
#include "runtime/plugin.h"
#include "runtime/studio/paint_command.h"

int main(int argc, char** argv) {
  terrazzo::Registry registry;
  terrazzo::register_nodes(registry);
  terrazzo::ValueTypes types;
  terrazzo::register_value_types(types);
  if (const char* plugins = std::getenv("TERRAZZO_PLUGIN_PATH"))
    for (const auto& d : terrazzo::load_plugins(plugins, registry, types)) std::cerr << d.text() << '\n';
  return terrazzo::run_command_line(
      argc, argv, {registry, types, terrazzo::read_provenance, terrazzo::studio::add_paint});
}
