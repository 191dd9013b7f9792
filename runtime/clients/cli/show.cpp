#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/progress.h"
#include "runtime/clients/cli/report.h"
#include "runtime/clients/cli/write_value.h"
#include "runtime/json_text.h"
#include "runtime/report/provenance.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct ShowOptions : GraphOptions {
  std::string target, file;
  bool json = false;
};

int write(const Program& program, Session& session, const ShowOptions& o) {
  Graph graph = *session.graph();
  const fs::path file = o.file;
  RunOptions options;
  options.targets = {append_writer(program.registry(), graph, graph.wire_to(o.target), file)};
  options.output_folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  options.threads = threads(o);
  options.memory = o.memory;
  options.cancel = cancel_on_interrupt();
  options.provenance = provenance(graph, session.overrides());
  ProgressLine line(session, options.targets, o.quiet, &graph);
  options.observer = &line;
  const RunResult result = session.evaluator().run(graph, options);
  line.close();
  finish(session, o);
  if (result.cancelled()) return kInterrupted;
  return result.failed() ? kNodeFailed : kDone;
}

int show(const Program& program, const ShowOptions& o) {
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  Session session(nodes.registry, nodes.types, session_options(o));
  if (!open_graph(session, o)) return kWrongUsage;
  if (!o.file.empty()) return write(program, session, o);
  const Wire wire = session.graph()->wire_to(o.target);
  ProgressLine line(session, {wire.node}, o.quiet);
  const auto evaluation = session.evaluate({o.target}, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (result.without_result) print(result.errors());  // so far they were warnings
  if (!result.trouble.empty()) std::cerr << "warning: " << result.trouble << '\n';
  finish(session, o);
  if (result.cancelled()) return kInterrupted;
  if (result.failed()) return kNodeFailed;
  const Value v = session.evaluator().value(*session.graph(), result, wire);
  const nlohmann::json described = v.type().describe(v.data());
  if (o.json)
    std::cout << json_text(described, 2) << '\n';
  else
    std::cout << v.type().name << '\n' << readable(v.type().name, described);
  return kDone;
}

}  // namespace

void add_show(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("show", "Evaluate one output and print its value");
  auto o = std::make_shared<ShowOptions>();
  add_graph_options(*command, *o);
  command->add_option("output", o->target, "NODE.PORT or a graph output")
      ->type_name(placeholder::output)
      ->required();
  add_run_options(*command, *o);
  command->add_flag("--json", o->json, "Print JSON");
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->add_option("-o,--output", o->file, "Write the value to this file instead of printing it")
      ->type_name(placeholder::file);
  command->callback([o, &program, &exit_code] { exit_code = show(program, *o); });
}

}  // namespace terrazzo::cli
