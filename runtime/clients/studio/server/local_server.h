// The HTTP side that all pages share: routes with JSON, access control, headers, errors.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "graph/diagnostic.h"
#include "runtime/clients/studio/server/access.h"

#include "runtime/clients/studio/server/http_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {

// Listens only on 127.0.0.1 and answers only clients that know its token (access.h). Errors are JSON:
// {code, message, hint}.
class LocalServer {
 public:
  // `command`: "paint". `stream`: the path of a response that goes on for long, or "". `body`: bytes of a
  // request's body, at most; `upload`: the same for uploads.
  explicit LocalServer(std::string command, std::string stream = {}, std::size_t body = 1 << 20,
                       std::size_t upload = 0);

  HttpServer& http() { return http_; }
  const Access& access() const { return access_; }

  // Serves a file of page/. "/" also sets the cookie.
  void add_page(const std::string& path, const std::string& file);

  // Parses the body of a POST as JSON, unless it is an upload of bytes, and answers with what `act` throws.
  using Act = std::function<void(const httplib::Request&, const nlohmann::json& body, httplib::Response&)>;
  httplib::Server::Handler handler(Act act) const { return handler(std::move(act), false); }
  httplib::Server::Handler upload_handler(Act act) const { return handler(std::move(act), true); }

  static void answer(httplib::Response&, const nlohmann::json&);
  static void refuse(httplib::Response&, int status, const Diagnostic&);

  // Binds a port (0: any free port) and returns its number. Throws Error "port-in-use".
  int bind(int port);
  // The address to open in a browser, with the token. Valid after bind().
  std::string address() const { return access_.address(); }

 private:
  httplib::Server::Handler handler(Act, bool upload) const;

  std::string command_;
  std::size_t body_;
  Access access_;
  HttpServer http_;
};

}  // namespace terrazzo::studio
