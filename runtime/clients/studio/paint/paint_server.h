// Serves a painting and its page, on this machine only. This class implements the HTTP interface; Painting
// does the painting.
#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace terrazzo::studio {

class Painting;
class SaveFile;

// GET /, /paint.js and /paint.css return the page. GET /api/state returns JSON. GET
// /api/view?kind=picture|base_relative|occupancy returns pixels of four bytes (RGBA). POST /api/nib,
// /api/stroke, /api/undo and /api/save take JSON. /api/stroke answers within `budget` milliseconds (16), with
// the number of points that are not painted yet (brush_queue.h); without points, it reports progress. Errors
// are {code, message, hint}. Listens only on 127.0.0.1 and answers only clients that know its token
// (access.h).
class PaintServer {
 public:
  // /api/save writes only `save_file`. `cancel` stops a stroke that is being painted.
  PaintServer(Painting&, SaveFile& save_file, const std::atomic<bool>* cancel = nullptr);
  ~PaintServer();

  // Binds a port (0: any free port) and returns its number. Throws Error "port-in-use".
  int bind(int port);
  // The address to open in a browser, with the token. Valid after bind().
  std::string address() const;
  // Serves until stop() is called. stop() may be called from any thread.
  void serve();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrazzo::studio
