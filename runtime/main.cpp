#include <cstdlib>
#include <iostream>

#include "runtime/clients/cli/command_line.h"
#include "runtime/clients/studio/library.h"
#include "runtime/clients/studio/paint/paint_options.h"
#include "runtime/clients/studio/studio_options.h"
#include "runtime/given.h"
#include "runtime/plugin.h"

namespace {

template <bool with_plugins>
const terrazzo::NodeSet& nodes() {
  static const terrazzo::NodeSet all = [] {
    const terrazzo::studio::Library& library = terrazzo::studio::library();
    terrazzo::NodeSet set;
    library.register_nodes(set.registry);
    library.register_value_types(set.types);
    set.read_provenance = library.read_provenance;
    if (!with_plugins) terrazzo::register_given_types(set.registry, set.types);  // for `terrazzo reproduce`
    if (const char* plugins = std::getenv("TERRAZZO_PLUGIN_PATH"); plugins && with_plugins)
      for (const auto& d : terrazzo::load_plugins(plugins, set.registry, set.types))
        std::cerr << d.text() << '\n';
    return set;
  }();
  return all;
}

void add_pages(CLI::App& app, int& exit_code) {
  terrazzo::studio::add_studio(app, nodes<true>, exit_code);
  terrazzo::studio::add_paint(app, exit_code);
}

}  // namespace

int main(int argc, char** argv) {
  return terrazzo::run_command_line(argc, argv, {nodes<true>, nodes<false>, add_pages});
}
