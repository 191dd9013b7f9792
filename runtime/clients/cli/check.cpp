#include <iostream>
#include <memory>

#include "graph/input_file.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/files.h"

namespace terrazzo::cli {

// Loading a graph does not look for its input files, so those that cannot be read are reported here.
static Diagnostics missing_files(const Graph& graph) {
  Diagnostics found;
  for (const auto& node : graph.nodes)
    for (const auto& p : node.type->parameters) {
      const auto it = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
      const auto& path = std::get<std::string>(it->second.value);
      const auto fail = [&](const char* code, const std::string& message) {
        found.push_back({Severity::Error, code, message, {}, it->second.place, node.path, p.name});
      };
      const auto files = expand_glob(path);
      if (files.empty()) fail("no-file", "there is no file '" + path + "'");
      for (const auto& name : files)
        if (const InputFile file(name); !file)
          fail("unreadable-file", "cannot read '" + name.string() + "': " + file.trouble());
    }
  return found;
}

void add_check(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("check", "Report every error in a graph without running it");
  auto o = std::make_shared<GraphOptions>();
  add_graph_options(*command, *o);
  command->callback([o, &program, &exit_code] {
    Session session(program.registry(), program.types());
    const bool ok = open_graph(session, *o);
    const Graph& graph = *session.graph();
    const Diagnostics missing = ok ? missing_files(graph) : Diagnostics{};
    print(missing);
    exit_code = ok && missing.empty() ? kDone : kWrongUsage;
    if (exit_code == kDone) std::cout << graph.file << ": " << graph.nodes.size() << " nodes, no errors\n";
  });
}

}  // namespace terrazzo::cli
