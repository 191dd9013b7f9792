#include "nodes/register_nodes.h"
#include "runtime/cli/command_line.h"

int main(int argc, char** argv) {
  terrazzo::Registry registry;
  terrazzo::register_nodes(registry);
  terrazzo::ValueTypes types;
  terrazzo::register_value_types(types);
  return terrazzo::run_command_line(argc, argv, {registry, types});
}
