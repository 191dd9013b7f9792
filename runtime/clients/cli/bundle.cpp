#include <iostream>
#include <memory>

#include "runtime/bundle/temporary_folder.h"
#include "runtime/bundle/write_bundle.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/progress.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct BundleCommand : GraphOptions {
  std::string to, license, source, preview;
  bool no_preview = false;
};

// How well a file that a node writes shows the material: 0 if it does not.
int rank_of_picture(const GraphNode& node, const std::string& stem) {
  const auto path = node.parameters.find("path");
  if (!node.type->writes_files || node.in_subgraph() || !node.inputs.count("image") ||
      path == node.parameters.end())
    return 0;
  const fs::path file = std::get<std::string>(path->second.value);
  if (file.extension() != ".png" && file.extension() != ".jpg") return 0;
  const std::string name = file.stem().string();
  return name == "preview" || name.ends_with("_preview") ? 3 : name == stem ? 2 : 1;
}

// Writes the picture of the material into a folder. Returns its path, or "" if the graph writes none.
fs::path write_preview(Session& session, const BundleCommand& o, const fs::path& folder) {
  const Graph& graph = *session.graph();
  const std::string stem = fs::path(o.graph).stem().string();
  const GraphNode* best = nullptr;
  for (const GraphNode& node : graph.nodes)
    if (rank_of_picture(node, stem) > (best ? rank_of_picture(*best, stem) : 0)) best = &node;
  if (!best) return {};
  session.set_output_folder(folder);
  ProgressLine line(session, target_nodes(graph, {best->path}), o.quiet);
  const auto evaluation = session.evaluate({best->path}, &line);
  const RunResult& result = evaluation->wait();
  line.close();
  if (result.cancelled()) throw Cancelled();
  for (const NodeResult& node : result.nodes)
    for (const FileRecord& file : node.files) return folder / file.path;
  throw Error("no-preview", "the picture of the material could not be made",
              "correct the errors, or use --no-preview");
}

int bundle(const Program& program, BundleCommand& o) {
  const NodeSet& nodes = program.nodes();
  Session session(nodes.registry, nodes.types, session_options(o));
  if (!open_graph(session, o)) return kWrongUsage;
  const fs::path graph = session.graph()->file;
  const fs::path to = o.to.empty() ? graph.stem().string() + ".zip" : o.to;
  const TemporaryFolder pictures(fs::temp_directory_path());
  fs::path preview = o.preview;
  if (preview.empty() && !o.no_preview) preview = write_preview(session, o, pictures.path());
  write_bundle(to, {.graph = graph, .license = o.license, .source = o.source, .preview = preview},
               nodes.registry);
  finish(session, o);
  std::cout << "wrote " << to.string() << '\n';
  return kDone;
}

}  // namespace

void add_bundle(CLI::App& app, const Program& program, int& exit_code) {
  auto* command =
      app.add_subcommand("bundle", "Put a graph and all that it reads into one folder or .zip, to share it");
  auto o = std::make_shared<BundleCommand>();
  command->add_option("graph", o->graph, "Graph file (YAML)")->type_name(placeholder::graph)->required();
  command
      ->add_option("--out", o->to,
                   "The bundle: a .zip, or a new folder (default: the graph's name with .zip)")
      ->type_name(placeholder::file);
  command->add_option("--license", o->license, "License of the material, such as \"CC BY 4.0\"")
      ->type_name("TEXT");
  command->add_option("--source", o->source, "Where the material and its pictures come from")
      ->type_name("TEXT");
  auto* preview =
      command
          ->add_option("--preview", o->preview,
                       "Picture of the material, PNG or JPEG (default: the one that the graph writes, which "
                       "is computed unless it is cached)")
          ->type_name(placeholder::image)
          ->check(CLI::ExistingFile);
  command->add_flag("--no-preview", o->no_preview, "Add no picture of the material")->excludes(preview);
  add_cache_options(*command, *o);
  command->add_flag("--quiet", o->quiet, "Print no progress");
  command->callback([o, &program, &exit_code] { exit_code = bundle(program, *o); });
}

}  // namespace terrazzo::cli
