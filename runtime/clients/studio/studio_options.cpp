// Part of the program itself, so that help does not load the studio library.
#include "runtime/clients/studio/studio_options.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/studio/library.h"

namespace terrazzo::studio {

void add_studio(CLI::App& app, const NodeSet& (*nodes)(), int& exit_code) {
  auto* command =
      app.add_subcommand("studio", "Show, edit and evaluate a graph, in a browser on this machine");
  auto o = std::make_shared<StudioOptions>();
  cli::add_graph_options(*command, *o)
      ->required(false)
      ->description(
          "Graph file (YAML), or a photograph, for which a graph is written to the current folder (default: "
          "the "
          "page asks)");
  cli::add_run_options(*command, *o);
  command->add_option("--port", o->port, "Port on 127.0.0.1; 0: any free port")
      ->type_name(cli::placeholder::number)
      ->check(CLI::Range(0, 65535));
  command->add_flag("--no-browser", o->no_browser, "Print the address without opening a browser");
  command->add_flag("--no-live", o->no_live, "Evaluate only on demand, not after every change");
  command->callback([o, nodes, &exit_code] { exit_code = library().studio(*o, nodes()); });
}

}  // namespace terrazzo::studio
