#include "runtime/studio/paint_command.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <thread>

#include "graph/utf8.h"
#include "runtime/cli/options.h"
#include "runtime/studio/paint_server.h"
#include "runtime/studio/painting.h"
#include "runtime/studio/save_file.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

SaveFile save_file(const PaintOptions& o) {
  const fs::path name = fs::absolute(
      o.save.empty() ? fs::path(fs::path(o.image).stem().string() + "_painted.yaml") : fs::path(o.save));
  if (!fs::is_directory(name.parent_path()))
    throw Error("usage", "there is no folder '" + name.parent_path().string() + "' to save to");
  return o.save.empty() ? SaveFile::numbered(name) : SaveFile::exactly(name, o.overwrite);
}

}  // namespace

int paint(const PaintOptions& o) {
  Painting painting(o.image);
  const std::atomic<bool>* cancel = cli::cancel_on_interrupt();
  SaveFile save = save_file(o);
  if (find_invalid_utf8(painting.graph(save.path())) != std::string::npos)
    throw Error("usage", "the picture's path is not UTF-8, so no graph file can name it",
                "rename the picture");
  PaintServer server(painting, save, cancel);
  server.bind(o.port);
  std::cout << server.address() << std::endl;
  std::cerr << "Open this address to paint on " << o.image << "; strokes are saved to "
            << save.path().string() << ". Ctrl-C ends.\n";
  std::atomic<bool> ended{false};
  std::thread watch([&] {
    while (!ended && !cancel->load()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    server.stop();
  });
  // Also where serve() throws: a thread that is not joined would end the program.
  const struct Joined {
    std::atomic<bool>& ended;
    std::thread& watch;
    ~Joined() {
      ended = true;
      watch.join();
    }
  } joined{ended, watch};
  server.serve();
  return cli::done;  // there is no other way to end it
}

}  // namespace terrazzo::studio
