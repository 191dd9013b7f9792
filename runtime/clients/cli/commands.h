// The commands of `terrazzo`, one file each. Each function declares a command's options and its callback.
#pragma once

#include <CLI/CLI.hpp>

#include "runtime/clients/cli/options.h"

namespace terrazzo::cli {

// Adds GRAPH and the options that several commands share. Returns GRAPH, which is required.
CLI::Option* add_graph_options(CLI::App&, GraphOptions&);
// NODE.PARAM=VALUE, repeatable.
void add_set_option(CLI::App&, GraphOptions&);
// NODE, NODE.PORT or a graph output, repeatable. `verb`: what is done with the node, such as "evaluate".
void add_target_option(CLI::App&, GraphOptions&, const std::string& verb);
void add_cache_options(CLI::App&, GraphOptions&);
void add_run_options(CLI::App&, GraphOptions&);  // cache options, --out, --threads, --memory

// Each function adds one command, whose callback stores the exit code.
void add_run(CLI::App&, const Program&, int& exit_code);
void add_texture(CLI::App&, const Program&, int& exit_code);
void add_check(CLI::App&, const Program&, int& exit_code);
void add_show(CLI::App&, const Program&, int& exit_code);
void add_explain(CLI::App&, const Program&, int& exit_code);
void add_methods(CLI::App&, const Program&, int& exit_code);
void add_bundle(CLI::App&, const Program&, int& exit_code);
void add_graph(CLI::App&, const Program&, int& exit_code);
void add_nodes(CLI::App&, const Program&, int& exit_code);
void add_schema(CLI::App&, const Program&, int& exit_code);
void add_sweep(CLI::App&, const Program&, int& exit_code);
void add_sweep_worker(CLI::App&, const Program&, int& exit_code);
void add_status(CLI::App&, int& exit_code);
void add_cache(CLI::App&, const Program&, int& exit_code);
void add_reproduce(CLI::App&, const Program&, int& exit_code);
void add_completion(CLI::App&);
void add_manual(CLI::App&);  // of this app

// Prints the plan of a run; shared by `explain` and `run --dry-run`.
void print_plan(Session&, const GraphOptions&, bool reasons);

}  // namespace terrazzo::cli
