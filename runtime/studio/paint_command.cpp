#include "runtime/studio/paint_command.h"

#include <chrono>
#include <filesystem>
#include <iostream>
#include <thread>

#include "runtime/cli/options.h"
#include "runtime/studio/paint_server.h"
#include "runtime/studio/painting.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;

int paint(const PaintOptions& o) {
  Painting painting(o.image);
  const fs::path save = fs::absolute(
      o.save.empty() ? fs::path(fs::path(o.image).stem().string() + "_painted.yaml") : fs::path(o.save));
  if (!fs::is_directory(save.parent_path()))
    throw Error("usage", "there is no folder '" + save.parent_path().string() + "' to save to");
  PaintServer server(painting, save);
  const int port = server.bind(o.port);
  std::cout << "http://127.0.0.1:" << port << "/" << std::endl;
  std::cerr << "Open this address to paint on " << o.image << "; strokes are saved to " << save.string()
            << ". Ctrl-C ends.\n";
  const std::atomic<bool>* cancel = cli::cancel_on_interrupt();
  std::atomic<bool> ended{false};
  std::thread watch([&] {
    while (!ended && !cancel->load()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    server.stop();
  });
  server.serve();
  ended = true;
  watch.join();
  return cli::done;  // there is no other way to end it
}

}  // namespace terrazzo::studio
