#include "runtime/clients/studio/paint/paint_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "nodes/common/texture/color.h"
#include "nodes/cooccurrence/texture_nib/views.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/clients/studio/paint/brush_queue.h"
#include "runtime/clients/studio/paint/painting.h"
#include "runtime/files/base64.h"

#include "runtime/clients/studio/server/local_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

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

NibOptions choice_of(const json& j) {
  NibOptions c;
  c.region = j.at("region").get<std::vector<double>>();
  c.levels = j.value("levels", c.levels);
  c.extent = j.value("extent", c.extent);
  c.scales = j.value("scales", c.scales);
  c.passes = j.value("passes", c.passes);
  c.finish = j.value("finish", c.finish);
  c.seed = j.value("seed", c.seed);
  if (j.contains("threshold") && !j["threshold"].is_null()) c.threshold = j["threshold"].get<double>();
  return c;
}

}  // namespace

// How long a request waits for points to be painted: one frame of a screen.
constexpr double kBudget = 16, kLongestBudget = 60000;  // ms

struct PaintServer::Impl {
  Painting& painting;
  SaveFile& save_file;
  const std::atomic<bool>* cancel;
  LocalServer server{"paint"};
  std::mutex mutex = {};  // only one thread at a time may use the queue
  BrushQueue queue{painting, cancel};

  Work work() const { return {cancel, nullptr}; }

  // Wraps `act` in a handler that locks the queue.
  template <class Act>
  httplib::Server::Handler handler(Act act) {
    return server.handler([this, act](const httplib::Request& in, const json& body, httplib::Response& out) {
      const std::lock_guard lock(mutex);
      work().check();  // after a canceled stroke, the painting is unusable
      act(in, body, out);
    });
  }

  json state() const {
    const Image& p = painting.picture();
    json nib = nullptr;
    if (const NibOptions* c = painting.choice())
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

  // Queues steps of a stroke, if there are any, and answers with what changed within the budget.
  void stroke(const json& body, httplib::Response& out) {
    const auto start = std::chrono::steady_clock::now();
    const double budget = body.value("budget", kBudget);
    if (!(budget >= 0 && budget <= kLongestBudget))
      throw Error("bad-request", fmt::format("budget must be between 0 and {} ms", kLongestBudget));
    if (body.value("begin", false)) queue.begin_stroke(body.at("radius").get<double>());
    for (const auto& point : body.value("points", json::array())) {
      if (!point.is_array() || point.size() != 2) throw Error("bad-stroke", "a point is [x, y]");
      queue.extend_stroke({point[0].get<double>(), point[1].get<double>()});
    }
    if (body.value("end", false)) queue.end_stroke();
    const auto progress = queue.wait(std::chrono::milliseconds(static_cast<int>(budget)));
    const Rectangle& r = progress.changed;
    std::string pixels;
    if (r.x1 > r.x0) queue.read([&](const Image& shown) { pixels = encode_base64(bytes_of(shown, r)); });
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    LocalServer::answer(out, {{"rectangle", {r.x0, r.y0, r.x1, r.y1}},
                              {"pixels", pixels},
                              {"pending", progress.points},
                              {"milliseconds", took.count()},
                              {"strokes", progress.strokes}});
  }

  void view(const std::string& kind, httplib::Response& out) {
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
    LocalServer::answer(out, {{"file", save_file.path().string()}, {"graph", graph}, {"note", note}});
  }

  void routes() {
    auto& http = server.http();
    server.add_page("/", "paint.html");
    for (const std::string name : {"paint.js", "paint.css"}) server.add_page("/" + name, name);
    const auto answer_state = [this](auto&, const json&, httplib::Response& out) {
      queue.idle([&] { LocalServer::answer(out, state()); });
    };
    http.Get("/api/state", handler(answer_state));
    http.Get("/api/view", handler([this](const httplib::Request& in, const json&, httplib::Response& out) {
               queue.idle([&] { view(in.get_param_value("kind"), out); });
             }));
    http.Post("/api/nib", handler([this, answer_state](const httplib::Request& in, const json& body,
                                                       httplib::Response& out) {
                const NibOptions choice = choice_of(body);
                queue.change([&] { painting.choose(choice, work()); });
                answer_state(in, body, out);
              }));
    http.Post("/api/stroke", handler([this](const httplib::Request&, const json& body,
                                            httplib::Response& out) { stroke(body, out); }));
    http.Post("/api/undo", handler([this, answer_state](const httplib::Request& in, const json& body,
                                                        httplib::Response& out) {
                if (!queue.undo()) throw Error("nothing-to-undo", "there is nothing to undo");
                answer_state(in, body, out);
              }));
    http.Post("/api/save", handler([this](const httplib::Request&, const json&, httplib::Response& out) {
                queue.idle([&] { save(out); });
              }));
  }
};

PaintServer::PaintServer(Painting& painting, SaveFile& save_file, const std::atomic<bool>* cancel)
    : impl_(new Impl{.painting = painting, .save_file = save_file, .cancel = cancel}) {
  impl_->routes();
}

PaintServer::~PaintServer() = default;

int PaintServer::bind(int port) { return impl_->server.bind(port); }

std::string PaintServer::address() const { return impl_->server.address(); }

void PaintServer::serve() { impl_->server.http().listen_after_bind(); }

void PaintServer::stop() { impl_->server.http().end(); }

}  // namespace terrazzo::studio
