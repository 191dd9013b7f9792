#include <fmt/format.h>
#include <unistd.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "graph/output_path.h"
#include "graph/raw_document.h"
#include "graph/write_graph.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/placeholders.h"
#include "runtime/cli/progress.h"
#include "runtime/cli/report.h"
#include "runtime/files.h"
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

// The provenance of a file.
struct Made {
  std::string document;
  std::map<std::string, std::string> keys;  // by node
  std::set<std::string> contents;           // content hashes of the input files
};

Made made_from_report(const json& report) {
  Made made{report.at("document"), {}, {}};
  for (const auto& node : report.at("nodes")) {
    made.keys[node.at("name")] = node.at("key");
    if (node.contains("reads"))
      for (const auto& f : node.at("reads")) made.contents.insert(f.at("content"));
  }
  return made;
}

// A file's content as JSON, or null if it is not JSON. Throws Error "too-large" if parsing needs too much
// memory.
json json_in(const fs::path& path) {
  constexpr double per_byte = 40;  // of parsed JSON
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) return nullptr;
  require_memory(per_byte * static_cast<double>(size), available_memory(), "'" + path.string() + "'");
  const auto text = read_file(path);
  return text ? json::parse(*text, nullptr, false) : json(nullptr);
}

// Formats without metadata fall back to a report.json in the file's folder or up to three folders above it.
std::optional<Made> made_by_report_beside(const fs::path& file) {
  const fs::path path = fs::absolute(file).lexically_normal();
  fs::path folder = path.parent_path();
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    const json report = json_in(folder / "report.json");
    if (!report.is_object() || !report.contains("document")) continue;
    const std::string name = path.lexically_relative(folder).string();
    for (const auto& node : report.at("nodes"))
      for (const auto& f : node.at("files"))
        if (f.at("path") == name) return made_from_report(report);
  }
  return {};
}

Made how_made(const Program& program, const fs::path& file) {
  if (::access(file.c_str(), R_OK) != 0) throw Error("usage", "cannot read '" + file.string() + "'");
  try {
    if (file.extension() == ".json")
      if (const json j = json_in(file); j.is_object() && j.contains("document")) return made_from_report(j);
    const std::string inside = program.nodes().read_provenance ? program.nodes().read_provenance(file) : "";
    if (const json j = json::parse(inside, nullptr, false); j.is_object() && j.contains("document")) {
      Made made{j.at("document"), {}, {}};
      for (const auto& [node, key] : j.at("keys").items()) made.keys[node] = key;
      if (j.contains("files"))
        for (const auto& f : j.at("files")) made.contents.insert(f.at("content"));
      return made;
    }
    if (const auto made = made_by_report_beside(file)) return *made;
  } catch (const json::exception& e) {
    throw Error("usage", "the provenance of '" + file.string() + "' is damaged: " + e.what());
  }
  throw Error("usage", "'" + file.string() + "' contains no provenance",
              "name a file that terrazzo wrote, or the report.json of its run");
}

// Input paths in the document are relative to the original output folder, which is the file's folder or one
// above it.
Graph open_made(const Program& program, const Made& made, const fs::path& file, const Overrides& overrides,
                Diagnostics& found) {
  fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  Graph first;
  for (int up = 0; up < 4; ++up, folder = folder.parent_path()) {
    Diagnostics here;
    Graph graph =
        load_graph_text(made.document, folder / "document.yaml", program.registry(), overrides, here);
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
      std::cout << fmt::format("{} has a different action key than in the original run\n",
                               graph.nodes[i].path);
  }
  std::cout << fmt::format("{} of {} nodes have the same action key as in the original run\n", same, all);
}

// The file may come from an untrusted source. Its graph may read only files whose content hash is in the
// provenance, unless the user grants access to others.
bool granted(const fs::path& file, const ReproduceCommand& o) {
  std::error_code error;
  const fs::path real = fs::canonical(file, error);
  if (error) return false;
  for (const auto& folder : o.allow_read) {
    const fs::path root = fs::canonical(folder, error);
    if (!error && !leaves_folder(real.lexically_relative(root))) return true;
  }
  return false;
}

bool is_from_command_line(const SetParameter& p) { return p.place.file.starts_with("command line"); }

// Prints the files that the graph would read. False if it may not read some of them.
bool show_reads(const Graph& graph, const Made& made, const ReproduceCommand& o) {
  FileHashes hashes;
  bool all = true;
  for (const auto& node : graph.nodes)
    for (const auto& p : node.type->parameters) {
      const auto it = node.parameters.find(p.name);
      if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
      for (const auto& path : expand_glob(std::get<std::string>(it->second.value))) {
        for (const auto& f : files_opened(*node.type, path)) {
          const bool allowed = is_from_command_line(it->second) || granted(f, o);
          const auto content = allowed ? std::nullopt : hashes.hash(f);
          const bool named = content && made.contents.count(content->text());
          if (!allowed && !named && !fs::exists(f)) continue;  // the run reports the missing file
          std::cout << "  reads  " << f.string()
                    << (allowed ? ""
                        : named ? ", the file it was made from"
                                : ", which is NOT the file it was made from")
                    << '\n';
          all = all && (allowed || named);
        }
      }
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
    std::cout << "  writes " << f.string() << (fs::exists(f) ? ", replacing the existing file" : "") << '\n';
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

// Subgraph files named in the document would be read without any check of their content.
void refuse_subgraphs(const Made& made) {
  Diagnostics ignored;
  for (const auto& node : read_document(made.document, "document.yaml", ignored).nodes)
    if (!node.graph.empty())
      throw Error("usage", "the graph that made this file refers to another graph file, '" + node.graph + "'",
                  "terrazzo writes self-contained graphs, so this one was modified");
}

int reproduce(const Program& with_plugins, ReproduceCommand& o) {
  const Program program{with_plugins.nodes_without_plugins, with_plugins.nodes_without_plugins, nullptr};
  const Made made = how_made(program, o.file);
  refuse_subgraphs(made);
  Diagnostics found;
  const Graph graph = open_made(program, made, o.file, overrides(o), found);
  print(found);
  if (has_errors(found)) return wrong_usage;
  const fs::path path = fs::path(o.out) / (fs::path(o.file).stem().string() + ".yaml");
  const std::string text = write_graph(graph, {}, o.out);
  std::cout << text << "\nThis graph\n";
  const bool may_read = show_reads(graph, made, o);
  show_writes(graph, path, o);
  if (!may_read)
    throw Error(
        "usage", "the graph would read files that the provenance does not name",
        "if you trust it, allow their folder with --allow-read DIR, or choose another file with --set");
  if (!confirmed(o)) return wrong_usage;
  write_text_atomically(path, text);
  std::cout << "wrote " << path.string() << '\n';
  o.graph = path.string();
  o.set.clear(), o.parameters.clear();     // already part of the written graph
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  Session session(nodes.registry, nodes.types, session_options(o));
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
                   "Folder whose files the graph may read, in addition to files with the recorded content "
                   "(repeatable)")
      ->type_name(placeholder::folder)
      ->take_all()
      ->expected(1);
  command->add_flag("--yes", o->yes, "Run without asking for confirmation");
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, &program, &exit_code] { exit_code = reproduce(program, *o); });
}

}  // namespace terrazzo::cli
