// Serves a painting and the page that shows it, on this machine alone. All that is said in HTTP is said here;
// what is painted is Painting's.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace terrazzo::studio {

class Painting;

// GET /, /paint.js, /paint.css; GET /api/state; GET /api/view?kind=picture|base_relative|occupancy: the
// pixels, four bytes each; POST /api/nib, /api/stroke, /api/undo, /api/save with JSON. Errors are {code,
// message, hint}. Listens on 127.0.0.1 only, and answers only what names it so in Host and, where there is
// one, Origin: no other page in the same browser may paint, nor any name that points here.
class PaintServer {
 public:
  // `save_as`: the only file that /api/save writes.
  PaintServer(Painting&, std::filesystem::path save_as);
  ~PaintServer();

  // Takes a port (0: any that is free). Throws Error "port-in-use".
  int bind(int port);
  // Serves until stop() is called, from any thread.
  void serve();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrazzo::studio
