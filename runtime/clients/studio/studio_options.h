// Options of the command `terrazzo studio [GRAPH]`.
#pragma once

#include "runtime/clients/cli/options.h"

namespace CLI {
class App;
}

namespace terrazzo {
struct NodeSet;
}

namespace terrazzo::studio {

struct StudioOptions : cli::GraphOptions {
  int port = 0;
  bool no_browser = false, no_live = false;
};

// `nodes`: loads the node types.
void add_studio(CLI::App&, const NodeSet& (*nodes)(), int& exit_code);

}  // namespace terrazzo::studio
