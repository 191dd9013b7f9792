#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/write_graph.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/progress.h"
#include "runtime/cli/report.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct ReproduceCommand : GraphOptions {
  std::string file;
};

// How a file was made.
struct Made {
  std::string document;
  std::map<std::string, std::string> keys;  // by node
};

Made made_from_report(const json& report) {
  Made made{report.at("document"), {}};
  for (const auto& node : report.at("nodes")) made.keys[node.at("name")] = node.at("key");
  return made;
}

// Formats without room for provenance are told of by the report that lies beside them, or above.
std::optional<Made> made_by_report_beside(const fs::path& file) {
  const fs::path path = fs::absolute(file).lexically_normal();
  fs::path folder = path.parent_path();
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    const auto text = read_file(folder / "report.json");
    if (!text) continue;
    const json report = json::parse(*text, nullptr, false);
    if (!report.is_object() || !report.contains("document")) continue;
    const std::string name = path.lexically_relative(folder).string();
    for (const auto& node : report.at("nodes"))
      for (const auto& f : node.at("files"))
        if (f.at("path") == name) return made_from_report(report);
  }
  return {};
}

Made how_made(const Program& program, const fs::path& file) {
  const auto text = read_file(file);
  if (!text) throw Error("usage", "cannot read '" + file.string() + "'");
  try {
    if (const json j = json::parse(*text, nullptr, false); j.is_object() && j.contains("document"))
      return made_from_report(j);
    const std::string inside = program.read_provenance ? program.read_provenance(file) : "";
    if (const json j = json::parse(inside, nullptr, false); j.is_object() && j.contains("document")) {
      Made made{j.at("document"), {}};
      for (const auto& [node, key] : j.at("keys").items()) made.keys[node] = key;
      return made;
    }
    if (const auto made = made_by_report_beside(file)) return *made;
  } catch (const json::exception& e) {
    throw Error("usage", "the provenance of '" + file.string() + "' is damaged: " + e.what());
  }
  throw Error("usage", "'" + file.string() + "' does not say how it was made",
              "a file written by terrazzo, or the report.json beside it, does");
}

// The files read lie relative to the folder that everything was written to, which is the file's or one above.
Graph open_made(const Program& program, const Made& made, const fs::path& file, const Overrides& overrides,
                Diagnostics& found) {
  fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  Graph first;
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    Diagnostics here;
    Graph graph = load_graph_text(made.document, folder / "document.yaml", program.registry, overrides, here);
    bool complete = true;
    for (const auto& node : graph.nodes)
      for (const auto& p : node.type->parameters)
        if (const auto it = node.parameters.find(p.name);
            p.kind == ParameterKind::InputPath && it != node.parameters.end())
          complete = complete && !expand_glob(std::get<std::string>(it->second.value)).empty();
    if (up == 0) first = graph, found = here;
    if (complete) return found = here, graph;
  }
  return first;
}

void compare_keys(const Graph& graph, const RunResult& result, const Made& made) {
  std::size_t same = 0, all = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const auto it = made.keys.find(graph.nodes[i].path);
    if (it == made.keys.end() || result.nodes[i].status == Status::Unneeded) continue;
    ++all;
    if (it->second == result.nodes[i].key.text())
      ++same;
    else
      std::cout << fmt::format("{} is computed from something else than it was then\n", graph.nodes[i].path);
  }
  std::cout << fmt::format("{} of {} nodes are computed from exactly the same as then\n", same, all);
}

int reproduce(const Program& program, ReproduceCommand& o) {
  const Made made = how_made(program, o.file);
  Diagnostics found;
  const Graph graph = open_made(program, made, o.file, overrides(o), found);
  print(found);
  if (has_errors(found)) return wrong_usage;
  const fs::path path = fs::path(o.out) / (fs::path(o.file).stem().string() + ".yaml");
  write_text_atomically(path, write_graph(graph, {}, o.out));
  std::cout << "wrote " << path.string() << '\n';
  o.graph = path.string();
  o.set.clear(), o.parameters.clear();  // they stand in the file now
  Session session(program.registry, program.types, session_options(o));
  if (!open_graph(session, o)) return wrong_usage;
  ProgressLine line(session, {}, o.quiet);
  const auto evaluation = session.evaluate({}, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (!o.quiet) print_table(std::cout, *session.graph(), result);
  compare_keys(*session.graph(), result, made);
  for (const auto& node : result.nodes)
    for (const auto& f : node.files) std::cout << "wrote " << (fs::path(o.out) / f.path).string() << '\n';
  finish(session, o);
  if (result.cancelled()) return interrupted;
  return result.failed() ? node_failed : done;
}

}  // namespace

void add_reproduce(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand(
      "reproduce", "Write the graph that made a file, overrides included, and run it again");
  auto o = std::make_shared<ReproduceCommand>();
  o->out = "reproduced";
  command->add_option("file", o->file, "A file that terrazzo wrote, or its report.json")->required();
  command->add_option("--set", o->set, "Change a parameter on the way: NODE.PARAM=VALUE")
      ->take_all()
      ->expected(1);
  add_run_options(*command, *o);
  command->add_flag("--quiet", o->quiet, "Errors only");
  command->callback([o, &program, &exit_code] { exit_code = reproduce(program, *o); });
}

}  // namespace terrazzo::cli
