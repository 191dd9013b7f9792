#include "runtime/clients/studio/server/studio_server.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "graph/describe.h"
#include "graph/text/read_number.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/server/graph_routes.h"
#include "runtime/clients/studio/server/start_routes.h"
#include "runtime/clients/studio/studio_bundle.h"
#include "runtime/clients/studio/views/value_views.h"
#include "runtime/json_text.h"

#include "runtime/clients/studio/server/local_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {
using nlohmann::json;
namespace {

constexpr const char* kEvents = "/api/events";
constexpr std::size_t kMostUpload = 64 << 20;
constexpr int kMostStreams = 32;  // each occupies a thread of the server's 64

std::string event_text(std::uint64_t number, const std::string& type, const std::string& data) {
  return "id: " + std::to_string(number) + "\nevent: " + type + "\ndata: " + data + "\n\n";
}

int number_in(const httplib::Request& in, const char* name, int otherwise, int lo, int hi) {
  if (!in.has_param(name)) return otherwise;
  const std::string text = in.get_param_value(name);
  const auto number = number_in_text<int>(text);
  if (!number || *number < 0) throw Error("bad-request", std::string("'") + name + "' is not a number");
  return std::clamp(*number, lo, hi);
}

}  // namespace

struct StudioServer::Impl {
  LiveGraph& live;
  const Registry& registry;
  StudioStart start;
  LocalServer server{"studio", kEvents, kMaxGraphBytes + (1 << 20), kMostUpload};
  std::atomic<int> streams{0};  // now open

  // A stream of events. Sends the whole state first, unless the client names an event that is still kept.
  void stream(const httplib::Request& in, httplib::Response& out) {
    if (streams >= kMostStreams)
      throw Error("too-many-pages", "too many pages show this graph", "close some of them");
    struct Client {
      std::atomic<int>& streams;
      std::uint64_t seen = 0;
      bool resumed = false;
      explicit Client(std::atomic<int>& s) : streams(s) { ++streams; }
      ~Client() { --streams; }
    };
    const auto client = std::make_shared<Client>(streams);
    const std::string last = in.get_header_value("Last-Event-ID");
    if (const auto seen = number_in_text<std::uint64_t>(last)) {
      client->seen = *seen;
      client->resumed = true;
    }
    out.set_chunked_content_provider(
        "text/event-stream", [this, client](std::size_t, httplib::DataSink& sink) {
          if (server.http().ended()) return false;
          const auto send = [&](const std::string& text) { return sink.write(text.data(), text.size()); };
          std::optional<std::vector<Event>> events;
          for (int k = 0; client->resumed && k < 10 && (!events || events->empty()); ++k) {
            if (!sink.is_writable() || server.http().ended()) return false;
            events = live.events().after(client->seen, std::chrono::milliseconds(100));
            if (!events) break;
          }
          if (!events) {
            const json state = live.state();
            client->seen = state.at("number");
            client->resumed = true;
            return send(event_text(client->seen, "state", json_text(state)));
          }
          if (events->empty()) return send(":\n\n");  // finds out whether the client is still there
          std::string text;
          for (const auto& e : *events) text += event_text(e.number, e.type, e.data);
          client->seen = events->back().number;
          return send(text);
        });
  }

  ValueView view(const httplib::Request& in, const Value& v) {
    const auto real = [&](const char* name, double otherwise, double most) {
      const std::string text = in.get_param_value(name);
      if (text.empty()) return otherwise;
      const auto value = read_number(text);
      if (!value || !(std::abs(*value) <= most))
        throw Error("bad-request", fmt::format("'{}' is not a number from {} to {}", name, -most, most));
      return *value;
    };
    const std::string shapes = in.get_param_value("shapes");
    return view_of(v, in.get_param_value("as"),
                   {.most = number_in(in, "most", 2048, 16, 8192),
                    .slice = {.grid = in.get_param_value("grid"),
                              .axis = number_in(in, "axis", 2, 0, 2),
                              .index = number_in(in, "section", 0, 0, 1 << 20),
                              .lo = real("lo", 0, 1e30),
                              .hi = real("hi", 1, 1e30)},
                    .shapes = shapes.empty() ? Value() : live.value(shapes),
                    .azimuth = real("azimuth", -41, 360)});
  }

  void value(const httplib::Request& in, httplib::Response& out) {
    std::string tag = "\"" + in.matches[1].str();
    for (const char* name : {"as", "section", "most", "grid", "axis", "lo", "hi", "shapes", "azimuth"})
      tag += "." + in.get_param_value(name);
    tag += "\"";
    const auto set_cached = [&] {
      out.headers.erase("Cache-Control");
      out.set_header("Cache-Control", "private, max-age=31536000, immutable");
      out.set_header("ETag", tag);
    };
    if (in.get_header_value("If-None-Match") == tag) {
      set_cached();
      out.status = 304;
      return;
    }
    const ValueView v = view(in, live.value(in.matches[1]));
    set_cached();
    out.set_content(v.body, v.type.c_str());
  }

  json types() const {
    json list = json::array();
    for (const auto& district : registry.by_district())
      for (const NodeType* type : district.types) list.push_back(describe_json(*type));
    return list;
  }

  void routes() {
    using In = httplib::Request;
    using Out = httplib::Response;
    auto& http = server.http();
    server.add_page("/", "studio.html");
    server.add_page("/events.js", "events.js");
    http.Get("/studio.js", [](const In&, Out& out) {
      out.set_header("Content-Encoding", "gzip");
      out.set_content(studio_bundle().data(), studio_bundle().size(), "text/javascript; charset=utf-8");
    });
    http.Get("/api/types",
             server.handler([this](const In&, const json&, Out& out) { LocalServer::answer(out, types()); }));
    http.Get("/api/state", server.handler([this](const In&, const json&, Out& out) {
      LocalServer::answer(out, live.state());
    }));
    http.Get(kEvents, server.handler([this](const In& in, const json&, Out& out) { stream(in, out); }));
    http.Get("/api/value/([0-9a-f]{8,64})",
             server.handler([this](const In& in, const json&, Out& out) { value(in, out); }));
    http.Get("/api/preview/([0-9]{1,18})", server.handler([this](const In& in, const json&, Out& out) {
      const Value preview = live.preview(number_in_text<std::uint64_t>(in.matches[1].str()).value_or(0));
      if (!preview) {
        out.status = 204;
        return;
      }
      const ValueView v = view(in, preview);
      out.set_content(v.body, v.type.c_str());
    }));
    const auto post = [&](const char* path, auto act) {
      http.Post(path, server.handler([this, act](const In&, const json& body, Out& out) {
        act(body);
        LocalServer::answer(out, {{"number", live.events().last()}});
      }));
    };
    const auto change = [&](const char* path, auto act) {
      post(path, [this, act](const json& body) {
        live.change([&](Document& d) { act(d, body); }, scope_of(body));
      });
    };
    change("/api/edit", [](Document& d, const json& body) {
      d.edit(edits_of(body.at("edits")), body.value("group", ""), places_of(body));
    });
    change("/api/text", [](Document& d, const json& body) { d.replace(body.at("text").get<std::string>()); });
    change("/api/undo", [](Document& d, const json&) {
      if (!d.undo()) throw Error("nothing-to-undo", "there is nothing to undo");
    });
    change("/api/redo", [](Document& d, const json&) {
      if (!d.redo()) throw Error("nothing-to-redo", "there is nothing to redo");
    });
    change("/api/save", [](Document& d, const json& body) { d.save(body.value("overwrite", false)); });
    change("/api/reload", [](Document& d, const json&) { d.reload(); });
    change("/api/recover", [](Document& d, const json& body) { d.recover(body.at("use").get<bool>()); });
    add_start_routes(server, live, registry, start);
    add_graph_routes(server, live, registry);
    post("/api/run",
         [this](const json& body) { live.evaluate(body.value("targets", std::vector<std::string>{})); });
    post("/api/view", [this](const json& body) { live.show(body.at("node").get<std::string>()); });
    post("/api/cancel", [this](const json& body) { live.cancel(body.value("node", "")); });
    post("/api/live", [this](const json& body) { live.set_live(body.at("live").get<bool>()); });
  }
};

StudioServer::StudioServer(LiveGraph& live, const Registry& registry, StudioStart start)
    : impl_(new Impl{.live = live, .registry = registry, .start = std::move(start)}) {
  impl_->routes();
}

StudioServer::~StudioServer() = default;

int StudioServer::bind(int port) { return impl_->server.bind(port); }

std::string StudioServer::address() const { return impl_->server.address(); }

void StudioServer::serve() { impl_->server.http().listen_after_bind(); }

void StudioServer::stop() { impl_->server.http().end(); }

bool has_studio_page() { return !studio_bundle().empty(); }

}  // namespace terrazzo::studio
