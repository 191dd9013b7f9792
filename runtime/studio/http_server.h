// httplib's server for a page on this machine, made so that no client can hold it up or fill its memory.
#pragma once

#include "runtime/studio/connections.h"

namespace terrazzo::studio {

// One request a connection. A request has a deadline and a size limit as a whole. If all threads are taken, a
// new connection ends the oldest one whose request is not complete.
class HttpServer : public httplib::Server {
 public:
  HttpServer(ConnectionLimits = {});
  // From any thread, before or while listening: listen_after_bind() returns once the handlers have.
  void end();

 private:
  bool process_and_close_socket(socket_t socket) override;

  ConnectionLimits limits_;
  Connections connections_;
  std::atomic<bool> ended_{false};
};

}  // namespace terrazzo::studio
