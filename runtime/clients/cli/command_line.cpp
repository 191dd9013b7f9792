#include "runtime/clients/cli/command_line.h"

#include <iostream>

#include "graph/exception_text.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/completion/complete.h"
#include "runtime/clients/cli/output.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/report/provenance.h"

namespace terrazzo {
namespace cli {

CLI::Option* add_graph_options(CLI::App& app, GraphOptions& o) {
  auto* graph = app.add_option("graph", o.graph, "Graph file (YAML), or a bundle")
                    ->type_name(placeholder::graph)
                    ->required();
  add_set_option(app, o);
  app.add_option("--param", o.parameters, "Set a graph parameter: NAME=VALUE (repeatable)")
      ->type_name(placeholder::graph_setting)
      ->take_all()
      ->expected(1);
  return graph;
}

void add_set_option(CLI::App& app, GraphOptions& o) {
  app.add_option("--set", o.set, "Override a node's parameter: NODE.PARAM=VALUE (repeatable)")
      ->type_name(placeholder::node_setting)
      ->take_all()
      ->expected(1);
}

void add_target_option(CLI::App& app, GraphOptions& o, const std::string& verb) {
  app.add_option("--target", o.targets,
                 "Node to " + verb +
                     ": NODE, NODE.PORT or a graph output (repeatable; default: graph outputs, nodes that "
                     "write files, and nodes without consumers)")
      ->type_name(placeholder::target)
      ->take_all()
      ->expected(1);
}

void add_cache_options(CLI::App& app, GraphOptions& o) {
  auto* cache = app.add_option("--cache", o.cache,
                               "Cache folder (default: $XDG_CACHE_HOME/terrazzo or ~/.cache/terrazzo)")
                    ->type_name(placeholder::folder);
  app.add_flag("--no-cache", o.no_cache, "Do not read or write the disk cache")->excludes(cache);
  app.add_option("--cache-limit", o.cache_limit,
                 "Maximum size of the disk cache in bytes, such as 500M or 20G")
      ->type_name(placeholder::bytes)
      ->transform(CLI::AsSizeValue(true))
      ->capture_default_str();
}

void add_run_options(CLI::App& app, GraphOptions& o) {
  app.add_option("--out", o.out, "Folder for output files")
      ->type_name(placeholder::folder)
      ->capture_default_str();
  app.add_option("--threads", o.threads, "Number of threads; 0: one per CPU core")
      ->type_name(placeholder::number)
      ->check(CLI::Range(0, 1024));
  app.add_option("--memory", o.memory,
                 "Bytes of results to keep in memory in addition to those in use, such as 500M or 4G "
                 "(default: 2 GiB). If given, also the limit for loading one file")
      ->type_name(placeholder::bytes)
      ->transform(CLI::AsSizeValue(true));
  add_cache_options(app, o);
}

}  // namespace cli

namespace {

int run_command(int argc, char** argv, const Program& program) {
  CLI::App app{"Terrazzo: reconstructs tileable 3D materials from photographs of cut surfaces", "terrazzo"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("terrazzo ") + program_version);
  int exit_code = cli::kDone;
  cli::add_run(app, program, exit_code);
  cli::add_texture(app, program, exit_code);
  cli::add_check(app, program, exit_code);
  cli::add_show(app, program, exit_code);
  cli::add_explain(app, program, exit_code);
  cli::add_methods(app, program, exit_code);
  cli::add_bundle(app, program, exit_code);
  cli::add_graph(app, program, exit_code);
  cli::add_nodes(app, program, exit_code);
  cli::add_schema(app, program, exit_code);
  cli::add_sweep(app, program, exit_code);
  cli::add_sweep_worker(app, program, exit_code);
  cli::add_status(app, exit_code);
  cli::add_cache(app, program, exit_code);
  cli::add_reproduce(app, program, exit_code);
  if (program.add_commands) program.add_commands(app, exit_code);
  cli::add_completion(app);
  cli::add_manual(app);
  // Not a declared command: help does not list it, and its words are not to be parsed.
  if (argc > 1 && std::string_view(argv[1]) == "complete")
    return cli::print_completions(app, program, {argv + 2, argv + argc});
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return cli::kWrongUsage;
  } catch (const Error& e) {
    std::cerr << e.what() << '\n';
    const auto& code = e.diagnostic().code;
    for (const char* usage : {"usage", "unknown-node", "unknown-port", "not-a-cache", "unsafe-folder",
                              "sweep-file", "overwrites-input", "same-file"})
      if (code == usage) return cli::kWrongUsage;
    return cli::kNodeFailed;
  } catch (const Cancelled&) {
    return cli::kInterrupted;
  } catch (const std::exception& e) {
    std::cerr << "error: " << exception_text(e) << '\n';
    return cli::kNodeFailed;
  }
  return exit_code;
}

}  // namespace

int run_command_line(int argc, char** argv, const Program& program) {
  cli::Output output;
  return output.finish(run_command(argc, argv, program));
}

}  // namespace terrazzo
