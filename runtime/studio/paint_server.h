// Serves a painting and the page that shows it, on this machine alone. All that is said in HTTP is said here;
// what is painted is Painting's.
#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace terrazzo::studio {

class Painting;
class SaveFile;

// GET /, /paint.js, /paint.css; GET /api/state; GET /api/view?kind=picture|base_relative|occupancy: the
// pixels, four bytes each; POST /api/nib, /api/stroke, /api/undo, /api/save with JSON. Errors are {code,
// message, hint}. Listens on 127.0.0.1 only. Answers only who knows its token (access.h).
class PaintServer {
 public:
  // /api/save writes `save_file` and nothing else. `cancel` ends a stroke that is being painted.
  PaintServer(Painting&, SaveFile& save_file, const std::atomic<bool>* cancel = nullptr);
  ~PaintServer();

  // Takes a port (0: any that is free). Throws Error "port-in-use".
  int bind(int port);
  // What to open in a browser, with the token in it; once the port is bound.
  std::string address() const;
  // Serves until stop() is called, from any thread.
  void serve();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrazzo::studio
