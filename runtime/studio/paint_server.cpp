#include "runtime/studio/paint_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/texture_nib/views.h"
#include "runtime/json_text.h"
#include "runtime/studio/access.h"
#include "runtime/studio/page_files.h"
#include "runtime/studio/painting.h"
#include "runtime/studio/save_file.h"

#include "runtime/studio/http_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {
using nlohmann::json;
using texture_nib::Rectangle;

namespace {

std::string bytes_of(const Image& image, const Rectangle& r) {
  std::string out;
  out.reserve(static_cast<std::size_t>(r.x1 - r.x0) * (r.y1 - r.y0) * 4);
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x) {
      const Vec3f c = linear_to_srgb(image.at(x, y));
      for (int k = 0; k < 3; ++k)
        out += static_cast<char>(static_cast<unsigned char>(std::lround(255 * std::clamp(c[k], 0.0f, 1.0f))));
      out += static_cast<char>(255);
    }
  return out;
}

std::string base64(const std::string& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
    };
    const unsigned v = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[v >> (18 - 6 * k) & 63];
  }
  return out;
}

Rectangle joined(const Rectangle& a, const Rectangle& b) {
  if (a.x1 <= a.x0) return b;
  if (b.x1 <= b.x0) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

NibChoice choice_of(const json& j) {
  NibChoice c;
  c.region = j.at("region").get<std::vector<double>>();
  c.levels = j.value("levels", c.levels), c.extent = j.value("extent", c.extent);
  c.scales = j.value("scales", c.scales), c.passes = j.value("passes", c.passes);
  c.finish = j.value("finish", c.finish), c.seed = j.value("seed", c.seed);
  if (j.contains("threshold") && !j["threshold"].is_null()) c.threshold = j["threshold"].get<double>();
  return c;
}

// The media type of a page file, by its extension.
const char* media_type(const std::string& name) {
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "text/html; charset=utf-8";
}

}  // namespace

struct PaintServer::Impl {
  Painting& painting;
  SaveFile& save_file;
  const std::atomic<bool>* cancel;
  Access access;
  HttpServer server;
  std::mutex mutex;  // only one thread at a time may use the painting

  Work work() const { return {cancel, nullptr}; }

  static void answer(httplib::Response& out, const json& j) {
    out.set_content(json_text(j), "application/json");
  }

  static void refuse(httplib::Response& out, int status, const Diagnostic& d) {
    out.status = status;
    answer(out, {{"code", d.code}, {"message", d.message}, {"hint", d.hint}});
  }

  // Wraps `act` in a handler that locks the painting, parses a JSON body and returns errors as JSON.
  template <class Act>
  httplib::Server::Handler handler(Act act) {
    return [this, act](const httplib::Request& in, httplib::Response& out) {
      try {
        json body;
        if (in.method == "POST") {
          if (!in.get_header_value("Content-Type").starts_with("application/json"))
            throw Error("bad-request", "the request's content type is not JSON", "send application/json");
          body = json::parse(in.body);
        }
        const std::lock_guard lock(mutex);
        work().check();  // after a cancelled stroke, the painting is unusable
        act(in, body, out);
      } catch (const Cancelled&) {
        refuse(out, 503, {Severity::Error, "ending", "terrazzo paint is shutting down", "", {}, "", ""});
      } catch (const Error& e) {
        refuse(out, 400, e.diagnostic());
      } catch (const json::exception& e) {
        refuse(out, 400, {Severity::Error, "bad-request", e.what(), "", {}, "", ""});
      } catch (const std::exception& e) {
        refuse(out, 500, {Severity::Error, "failed", e.what(), "", {}, "", ""});
      }
    };
  }

  json state() const {
    const Image& p = painting.picture();
    json nib = nullptr;
    if (const NibChoice* c = painting.choice())
      nib = {{"region", c->region},
             {"levels", c->levels},
             {"extent", c->extent},
             {"scales", c->scales},
             {"finish", c->finish},
             {"threshold", painting.nib()->texture().threshold},
             {"error", painting.nib()->error()}};
    return {{"name", painting.file().filename().string()},
            {"width", p.width},
            {"height", p.height},
            {"nib", nib},
            {"strokes", painting.strokes()},
            {"save_as", save_file.path().string()},
            {"content", painting.content()}};
  }

  void stroke(const json& body, httplib::Response& out) {
    const auto start = std::chrono::steady_clock::now();
    if (body.value("begin", false)) painting.begin_stroke(body.at("radius").get<double>());
    Rectangle changed;
    for (const auto& point : body.at("points")) {
      if (!point.is_array() || point.size() != 2) throw Error("bad-stroke", "a point is [x, y]");
      changed =
          joined(changed, painting.extend_stroke({point[0].get<double>(), point[1].get<double>()}, work()));
    }
    if (body.value("end", false)) painting.end_stroke();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    const bool any = changed.x1 > changed.x0;
    answer(out, {{"rectangle", {changed.x0, changed.y0, changed.x1, changed.y1}},
                 {"pixels", any ? base64(bytes_of(painting.picture(), changed)) : ""},
                 {"milliseconds", took.count()},
                 {"strokes", painting.strokes()}});
  }

  void view(const std::string& kind, httplib::Response& out) const {
    const Image& p = painting.picture();
    const Rectangle all{0, 0, p.width, p.height};
    if (kind == "picture") return out.set_content(bytes_of(p, all), "application/octet-stream");
    if (kind != "base_relative" && kind != "occupancy")
      throw Error("bad-request", "there is no view '" + kind + "'",
                  "choose picture, base_relative or occupancy");
    if (!painting.nib()) throw Error("no-nib", "there is no nib yet", "pick a region of the image first");
    const Image drawn = kind == "occupancy" ? texture_nib::occupancy_view(*painting.nib())
                                            : texture_nib::base_relative_view(*painting.nib());
    out.set_content(bytes_of(drawn, all), "application/octet-stream");
  }

  void save(httplib::Response& out) {
    const std::string before = save_file.path().string();
    std::string graph;
    const bool moved = save_file.write([&](const auto& file) { return graph = painting.graph(file); });
    const std::string note =
        moved ? fmt::format("'{}' was changed by another program, so it was left as it is", before) : "";
    answer(out, {{"file", save_file.path().string()}, {"graph", graph}, {"note", note}});
  }

  void routes() {
    // The library's default, SO_REUSEPORT, would let a second program share the port.
    server.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_default_headers(
        {{"X-Content-Type-Options", "nosniff"},
         {"Cross-Origin-Resource-Policy", "same-origin"},
         {"Referrer-Policy", "no-referrer"},
         {"Content-Security-Policy", "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'"},
         {"Cache-Control", "no-store"}});
    server.set_pre_routing_handler([this](const httplib::Request& in, httplib::Response& out) {
      const auto refusal = access.refusal(in);
      if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
      refuse(out, refusal->status, refusal->why);
      return httplib::Server::HandlerResponse::Handled;
    });
    server.set_expect_100_continue_handler([](const httplib::Request&, httplib::Response& out) {
      return out.status = 400;  // the page never sends Expect: 100-continue
    });
    for (const std::string name : {"paint.html", "paint.js", "paint.css"})
      server.Get(name == "paint.html" ? "/" : "/" + name,
                 [this, name](const httplib::Request&, httplib::Response& out) {
                   if (name == "paint.html") out.set_header("Set-Cookie", access.cookie());
                   out.set_content(page_file(name), media_type(name));
                 });
    const auto answer_state = [this](auto&, const json&, httplib::Response& out) { answer(out, state()); };
    server.Get("/api/state", handler(answer_state));
    server.Get("/api/view", handler([this](const httplib::Request& in, const json&, httplib::Response& out) {
                 view(in.get_param_value("kind"), out);
               }));
    server.Post("/api/nib", handler([this, answer_state](const httplib::Request& in, const json& body,
                                                         httplib::Response& out) {
                  painting.choose(choice_of(body), work());
                  answer_state(in, body, out);
                }));
    server.Post("/api/stroke", handler([this](const httplib::Request&, const json& body,
                                              httplib::Response& out) { stroke(body, out); }));
    server.Post("/api/undo", handler([this, answer_state](const httplib::Request& in, const json& body,
                                                          httplib::Response& out) {
                  if (!painting.undo(work())) throw Error("nothing-to-undo", "there is nothing to undo");
                  answer_state(in, body, out);
                }));
    server.Post("/api/save",
                handler([this](const httplib::Request&, const json&, httplib::Response& out) { save(out); }));
    server.set_error_handler([](const httplib::Request& in, httplib::Response& out) {
      if (!out.body.empty()) return;
      Diagnostic d{Severity::Error, "bad-request", "the request is malformed or too slow", "", {}, "", ""};
      if (out.status == 413) d.code = "too-large", d.message = "the request is too large";
      if (out.status == 404) d.code = "not-found", d.message = "there is nothing at " + in.path;
      refuse(out, out.status, d);
    });
  }
};

PaintServer::PaintServer(Painting& painting, SaveFile& save_file, const std::atomic<bool>* cancel)
    : impl_(new Impl{painting, save_file, cancel, {}, {}, {}}) {
  impl_->routes();
}

PaintServer::~PaintServer() = default;

int PaintServer::bind(int port) {
  auto& server = impl_->server;
  const int bound = port == 0                                ? server.bind_to_any_port("127.0.0.1")
                    : server.bind_to_port("127.0.0.1", port) ? port
                                                             : -1;
  if (bound <= 0)
    throw Error("port-in-use", fmt::format("cannot listen on port {} of 127.0.0.1", port),
                "omit --port to use any free port");
  impl_->access.set_port(bound);
  return bound;
}

std::string PaintServer::address() const { return impl_->access.address(); }

void PaintServer::serve() { impl_->server.listen_after_bind(); }

void PaintServer::stop() { impl_->server.end(); }

}  // namespace terrazzo::studio
