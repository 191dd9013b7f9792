// An httplib server for a page on this machine, hardened so that no client can block it or exhaust its
// memory.
#pragma once

#include "runtime/clients/studio/server/connections.h"

namespace terrazzo::studio {

// Serves one request per connection. The deadline and the size limit apply to the whole request. If all
// threads are busy, a new connection ends the oldest connection whose request is incomplete.
class HttpServer : public httplib::Server {
 public:
  // `stream`: the path whose responses go on for long, or "".
  explicit HttpServer(std::string stream = {}, ConnectionLimits = {});
  bool ended() const { return ended_; }
  // Stops the server. Callable from any thread, before or while listening. listen_after_bind() returns when
  // all handlers have returned.
  void end();

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::string stream_;
  ConnectionLimits limits_;
  Connections connections_;
  std::atomic<bool> ended_{false};
};

}  // namespace terrazzo::studio
