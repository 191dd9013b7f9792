#include <fmt/format.h>
#include <unistd.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "graph/document/raw_document.h"
#include "graph/document/write_graph.h"
#include "graph/output_path.h"
#include "graph/text/utf8.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/made.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/progress.h"
#include "runtime/clients/cli/report.h"
#include "runtime/files.h"
#include "runtime/files/protected_files.h"
#include "runtime/memory.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct ReproduceCommand : GraphOptions {
  std::string file;
  std::vector<std::string> allow_read;
  bool yes = false;
};

void compare_keys(const Graph& graph, const RunResult& result, const Made& made) {
  std::size_t same = 0, all = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const auto it = made.keys.find(graph.nodes[i].path);
    if (it == made.keys.end() || result.nodes[i].status == Status::Unneeded) continue;
    ++all;
    if (it->second == result.nodes[i].key.text())
      ++same;
    else
      std::cout << fmt::format("{} has a different action key than in the original run\n",
                               graph.nodes[i].path);
  }
  std::cout << fmt::format("{} of {} nodes have the same action key as in the original run\n", same, all);
}

// Prints the files that the graph would read. False if it may not read some of them.
bool show_reads(const Graph& graph, const Made& made, const ReproduceCommand& o) {
  bool all = true;
  for (const auto& node : graph.nodes)
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name);
          p.kind == ParameterKind::InputPath && it != node.parameters.end())
        if (const fs::path path = std::get<std::string>(it->second.value); expand_glob(path).empty())
          std::cout << fmt::format(
              "  reads  {}, which was not found (--set {}.{}=FILE names it, --allow-read FOLDER its "
              "folder)\n",
              escape_line(path.filename().string()), node.path, p.name);
  for (const auto& read : reads_of(graph, made, o.allow_read)) {
    std::cout << "  reads  " << escape_line(read.file.string())
              << (read.granted ? ""
                  : read.named ? ", the file it was made from"
                               : ", which is NOT the file it was made from")
              << '\n';
    all = all && read.allowed();
  }
  return all;
}

// Prints the output paths in the graph. A node that writes an image stack writes several files per path.
void show_writes(const Graph& graph, const fs::path& graph_file, const ReproduceCommand& o) {
  std::vector<fs::path> files{graph_file};
  for (const auto& node : graph.nodes)
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name);
          p.kind == ParameterKind::OutputPath && it != node.parameters.end())
        files.push_back(fs::path(o.out) / std::get<std::string>(it->second.value));
  for (const auto& f : files)
    std::cout << "  writes " << escape_line(f.string())
              << (fs::exists(f) ? ", replacing the existing file" : "") << '\n';
}

bool confirmed(const ReproduceCommand& o) {
  if (o.yes) return true;
  if (!::isatty(STDIN_FILENO)) {
    std::cerr << "error: nothing was run: there is no terminal to ask on (--yes runs without asking)\n";
    return false;
  }
  std::cout << "Run this? [y/N] " << std::flush;
  std::string answer;
  return std::getline(std::cin, answer) && (answer == "y" || answer == "yes");
}

int reproduce(const Program& with_plugins, ReproduceCommand& o) {
  const Program program{with_plugins.nodes_without_plugins, with_plugins.nodes_without_plugins, nullptr};
  const Made made = how_made(o.file, program.nodes().types, program.nodes().read_provenance);
  Diagnostics found;
  const Graph graph = open_made(program.registry(), made, o.file, overrides(o), o.allow_read, found);
  print(found);
  if (has_errors(found)) return kWrongUsage;
  const fs::path path = fs::path(o.out) / (fs::path(o.file).stem().string() + ".yaml");
  const std::string text = write_graph(graph, {}, o.out);
  ProtectedFiles keep(graph);
  keep.add(o.file, "which was given");
  keep.require_other(path);
  require_replaceable(path);
  std::cout << text << "\nThis graph\n";
  const bool may_read = show_reads(graph, made, o);
  show_writes(graph, path, o);
  if (!made.values.empty())
    std::cout << "  contains arrays that Python gave, so only `terrazzo reproduce` can run it. In Python,\n"
                 "  t.reproduce(FILE).save(GRAPH, arrays=FOLDER) writes them to files\n";
  if (!may_read)
    throw Error(
        "usage", "the graph would read files that the provenance does not name",
        "if you trust it, allow their folder with --allow-read DIR, or choose another file with --set");
  if (!confirmed(o)) return kWrongUsage;
  write_text_atomically(path, keep, text);
  std::cout << "wrote " << path.string() << '\n';
  o.graph = path.string();
  o.set.clear(), o.parameters.clear();     // already part of the written graph
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  Session session(nodes.registry, nodes.types, session_options(o));
  if (!open_graph(session, o)) return kWrongUsage;
  ProgressLine line(session, {}, o.quiet);
  const auto evaluation = session.evaluate({}, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (!o.quiet) print_table(std::cout, *session.graph(), result);
  compare_keys(*session.graph(), result, made);
  for (const auto& node : result.nodes)
    for (const auto& f : node.files) std::cout << "wrote " << (fs::path(o.out) / f.path).string() << '\n';
  finish(session, o);
  if (result.cancelled()) return kInterrupted;
  return result.failed() ? kNodeFailed : kDone;
}

}  // namespace

void add_reproduce(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand(
      "reproduce",
      "Show the graph that made a file and the files it reads and writes, and rerun it after confirmation");
  auto o = std::make_shared<ReproduceCommand>();
  o->out = "reproduced";
  command->add_option("file", o->file, "A file that terrazzo wrote, or its report.json")
      ->type_name(placeholder::file)
      ->required();
  add_set_option(*command, *o);
  add_run_options(*command, *o);
  command
      ->add_option("--allow-read", o->allow_read,
                   "Folder whose files the graph may read, in addition to files with the recorded content; "
                   "it is also searched for them (repeatable)")
      ->type_name(placeholder::folder)
      ->take_all()
      ->expected(1);
  command->add_flag("--yes", o->yes, "Run without asking for confirmation");
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, &program, &exit_code] { exit_code = reproduce(program, *o); });
}

}  // namespace terrazzo::cli
