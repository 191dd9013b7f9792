// Serves a LiveGraph and its page, on this machine only.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "graph/registry.h"

namespace terrazzo::studio {

class LiveGraph;

// GET /: the page. GET /api/types: the node types. GET /api/state: everything. GET /api/events: server-sent
// events, starting with the state, or after the number in Last-Event-ID. GET /api/value/HASH?as=…: a value
// (value_views.h), with an ETag. POST /api/edit {edits, merge}, /api/text {text}, /api/undo, /api/redo,
// /api/save {overwrite}, /api/reload, /api/recover {use}, /api/run {targets}, /api/cancel {node}, /api/live
// {live}. Errors are {code, message, hint}.
class StudioServer {
 public:
  StudioServer(LiveGraph&, const Registry&);
  ~StudioServer();

  // Binds a port (0: any free port) and returns its number. Throws Error "port-in-use".
  int bind(int port);
  std::string address() const;  // with the token; valid after bind()
  // Serves until stop() is called. stop() may be called from any thread.
  void serve();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Whether the program contains the page.
bool has_studio_page();

}  // namespace terrazzo::studio
