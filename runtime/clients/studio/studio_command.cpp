#include "runtime/clients/studio/studio_command.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <utility>

#include "runtime/bundle/bundle.h"
#include "runtime/clients/cli/default_graph.h"
#include "runtime/clients/cli/output.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/new_material.h"
#include "runtime/clients/studio/own_graphs.h"
#include "runtime/clients/studio/server/serve.h"
#include "runtime/clients/studio/server/studio_server.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

void open_browser(const std::string& address) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  std::string program = "xdg-open", argument = address;
  char* argv[] = {program.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t quiet;
  ::posix_spawn_file_actions_init(&quiet);
  ::posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  if (::posix_spawnp(&child, argv[0], &quiet, nullptr, argv, environ) == 0) ::waitpid(child, nullptr, 0);
  ::posix_spawn_file_actions_destroy(&quiet);
}

}  // namespace

int studio(const StudioOptions& o, const NodeSet& nodes) {
  if (!has_studio_page())
    throw Error("no-page", "this program was built without the page of the Studio",
                "build it with ./dev studio, or configure with -DTERRAZZO_STUDIO_PAGE=FILE");
  const bool is_default = o.graph.empty();
  fs::path file = is_default ? cli::default_graph() : fs::path(o.graph);
  Overrides overrides = cli::overrides(o);
  if (is_picture_name(file)) {
    const NewFile made = create_graph(file, fs::current_path(), std::exchange(overrides.parameters, {}));
    file = made.path;
    if (made.written) std::cerr << "Wrote " << file.string() << ".\n";
  }
  if (is_bundle(file)) file = graph_of_bundle(file, fs::current_path(), nodes.registry);
  if (file.empty())
    throw Error("usage", "no graph is given, and the default graph is not installed with this program",
                "name a graph file: terrazzo studio GRAPH");
  // Without a word about the default material, it waits until the page says that it is wanted.
  const bool welcome = is_default && o.set.empty() && o.parameters.empty();
  LiveGraph live(nodes.registry, nodes.types, cli::session_options(o), Document(file, is_default), overrides,
                 !o.no_live && !welcome);
  StudioServer server(live, nodes.registry, {.welcome = welcome, .live = !o.no_live});
  server.bind(o.port);
  std::cout << server.address() << std::endl;
  cli::require_output();
  std::cerr << "Open this address in a browser to work on " << file.string() << ". Files go to " << o.out
            << ". Press Ctrl-C to stop.\n";
  if (!o.no_browser) open_browser(server.address());
  serve_until(
      *cli::cancel_on_interrupt(), [&] { server.serve(); }, [&] { server.stop(); });
  return cli::kDone;  // Ctrl-C is the normal way to stop
}

}  // namespace terrazzo::studio
