#include "runtime/report/methods.h"

#include <iostream>
#include <memory>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/report.h"
#include "runtime/report/provenance.h"

namespace terrazzo::cli {

void add_methods(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("methods", "Print a paragraph on a graph's methods, with their sources");
  auto o = std::make_shared<GraphOptions>();
  add_graph_options(*command, *o);
  add_target_option(*command, *o, "describe");
  command->callback([o, &program, &exit_code] {
    Session session(program.registry(), program.types());
    if (!open_graph(session, *o)) {
      exit_code = kWrongUsage;
      return;
    }
    const Graph& graph = *session.graph();
    std::cout << methods_text(graph, target_nodes(graph, o->targets), program.registry(), program_version);
  });
}

}  // namespace terrazzo::cli
