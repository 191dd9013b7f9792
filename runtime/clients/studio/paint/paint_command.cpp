#include "runtime/clients/studio/paint/paint_command.h"

#include <atomic>
#include <filesystem>
#include <iostream>

#include "graph/text/utf8.h"
#include "runtime/clients/cli/options.h"
#include "runtime/clients/cli/output.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/clients/studio/paint/paint_server.h"
#include "runtime/clients/studio/paint/painting.h"
#include "runtime/clients/studio/server/serve.h"
#include "runtime/files/protected_files.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

SaveFile save_file(const PaintOptions& o) {
  const fs::path name = fs::absolute(
      o.save.empty() ? fs::path(fs::path(o.image).stem().string() + "_painted.yaml") : fs::path(o.save));
  ProtectedFiles keep;
  keep.add(o.image, "which is painted");
  keep.require_other(name);
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
    throw Error("usage", "the image's path is not UTF-8, so no graph file can refer to it",
                "rename the image");
  PaintServer server(painting, save, cancel);
  server.bind(o.port);
  std::cout << server.address() << std::endl;
  cli::require_output();
  std::cerr << "Open this address in a browser to paint on " << o.image << ". The page saves to "
            << save.path().string() << ". Press Ctrl-C to stop.\n";
  serve_until(
      *cancel, [&] { server.serve(); }, [&] { server.stop(); });
  return cli::kDone;  // Ctrl-C is the normal way to stop
}

}  // namespace terrazzo::studio
