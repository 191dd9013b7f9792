#include "runtime/clients/studio/server/local_server.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "graph/exception_text.h"
#include "runtime/clients/studio/server/page_files.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
using nlohmann::json;
namespace {

constexpr const char* kUpload = "application/octet-stream";
constexpr std::size_t kSlowestUpload = 128 << 10;  // bytes per second, over a forwarded port

// The media type of a page file, by its extension.
const char* media_type(const std::string& name) {
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "text/html; charset=utf-8";
}

}  // namespace

LocalServer::LocalServer(std::string command, std::string stream, std::size_t body, std::size_t upload)
    : command_(command),
      body_(body),
      access_(std::move(command)),
      http_(std::move(stream),
            {.body = std::max(body, upload), .slowest = upload > 0 ? kSlowestUpload : std::size_t{0}}) {
  // The library's default, SO_REUSEPORT, would let a second program share the port.
  http_.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  http_.set_default_headers(
      {{"X-Content-Type-Options", "nosniff"},
       {"Cross-Origin-Resource-Policy", "same-origin"},
       {"Referrer-Policy", "no-referrer"},
       {"Content-Security-Policy",
        "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'none'"},
       {"Cache-Control", "no-store"}});
  http_.set_pre_routing_handler([this](const httplib::Request& in, httplib::Response& out) {
    // Otherwise the library packs text with Brotli's best level, which takes longer than everything else:
    // half a second for the node types. There is no other way to turn it off; the request is a variable of
    // the library's.
    const_cast<httplib::Request&>(in).headers.erase("Accept-Encoding");
    const auto refusal = access_.refusal(in);
    if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
    refuse(out, refusal->status, refusal->why);
    return httplib::Server::HandlerResponse::Handled;
  });
  http_.set_expect_100_continue_handler([](const httplib::Request&, httplib::Response& out) {
    return out.status = 400;  // pages never send Expect: 100-continue
  });
  http_.set_error_handler([](const httplib::Request& in, httplib::Response& out) {
    if (!out.body.empty()) return;
    Diagnostic d{Severity::Error, "bad-request", "the request is malformed or too slow", "", {}, "", ""};
    if (out.status == 413) {
      d.code = "too-large";
      d.message = "the request is too large";
    }
    if (out.status == 404) {
      d.code = "not-found";
      d.message = "there is nothing at " + in.path;
    }
    refuse(out, out.status, d);
  });
}

void LocalServer::add_page(const std::string& path, const std::string& file) {
  http_.Get(path, [this, path, file](const httplib::Request&, httplib::Response& out) {
    if (path == "/") out.set_header("Set-Cookie", access_.cookie());
    out.set_content(page_file(file), media_type(file));
  });
}

void LocalServer::answer(httplib::Response& out, const json& j) {
  out.set_content(json_text(j), "application/json");
}

void LocalServer::refuse(httplib::Response& out, int status, const Diagnostic& d) {
  out.status = status;
  answer(out, {{"code", d.code}, {"message", d.message}, {"hint", d.hint}});
}

httplib::Server::Handler LocalServer::handler(Act act, bool upload) const {
  return [this, upload, act = std::move(act)](const httplib::Request& in, httplib::Response& out) {
    const auto fail = [&](int status, const char* code, std::string message) {
      refuse(out, status, {Severity::Error, code, std::move(message), "", {}, "", ""});
    };
    try {
      json body;
      if (upload && in.get_header_value("Content-Type") != kUpload)
        throw Error("bad-request", "the request's content type is not bytes",
                    "send application/octet-stream");
      if (!upload && in.body.size() > body_) return fail(413, "too-large", "the request is too large");
      if (in.method == "POST" && !upload) {
        if (!in.get_header_value("Content-Type").starts_with("application/json"))
          throw Error("bad-request", "the request's content type is not JSON", "send application/json");
        try {
          body = parse_json(in.body);
        } catch (const Error& e) {
          throw Error("bad-request", "the request is not JSON: " + e.diagnostic().message);
        }
      }
      act(in, body, out);
    } catch (const Cancelled&) {
      fail(503, "ending", "terrazzo " + command_ + " is shutting down");
    } catch (const Error& e) {
      refuse(out, 400, e.diagnostic());
    } catch (const json::exception& e) {
      fail(400, "bad-request", json_problem(e));
    } catch (const std::exception& e) {
      fail(500, "failed", exception_text(e));
    }
  };
}

int LocalServer::bind(int port) {
  const int bound = port == 0                               ? http_.bind_to_any_port("127.0.0.1")
                    : http_.bind_to_port("127.0.0.1", port) ? port
                                                            : -1;
  if (bound <= 0)
    throw Error("port-in-use", fmt::format("cannot listen on port {} of 127.0.0.1", port),
                "omit --port to use any free port");
  access_.set_port(bound);
  return bound;
}

}  // namespace terrazzo::studio
