// Serves a LiveGraph and its page, on this machine only.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "graph/registry.h"
#include "runtime/clients/studio/workspace.h"

namespace terrazzo::studio {

class LiveGraph;

// What the page offers at the start, and where it may create files.
struct StudioStart {
  Workspace workspace = Workspace{};
  bool welcome = false;  // no graph was named: ask for one
  bool live = true;      // evaluate the graph that the page opens first
};

// GET /: the page. GET /api/types: the node types. GET /api/state: everything. GET /api/events: server-sent
// events, starting with the state, or after the number in Last-Event-ID. GET /api/value/HASH?as=…: a value
// (value_views.h), with an ETag. GET /api/preview/NUMBER?as=…: a preliminary value, or status 204 if it has
// given way to a newer one. POST /api/edit {edits, group, places}, /api/text {text}, /api/undo, /api/redo,
// /api/save {overwrite}, /api/reload, /api/recover {use}, /api/run {targets}, /api/cancel {node}, /api/view
// {node}, /api/live {live}. The page's start: start_routes.h. Errors are {code, message, hint}.
class StudioServer {
 public:
  StudioServer(LiveGraph&, const Registry&, StudioStart = {});
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
