#include "runtime/clients/studio/server/start_routes.h"

#include <atomic>
#include <charconv>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "graph/text/utf8.h"
#include "nodes/common/io/image_file.h"
#include "runtime/bundle/bundle.h"
#include "runtime/bundle/temporary_folder.h"
#include "runtime/bundle/write_bundle.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/new_material.h"
#include "runtime/clients/studio/own_graphs.h"
#include "runtime/clients/studio/server/studio_server.h"
#include "runtime/clients/studio/views/materials.h"
#include "runtime/files.h"

#include "runtime/clients/studio/server/local_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// The last component of a file name that a browser sent, without characters that graphs cannot refer to.
std::string file_name(const std::string& sent) {
  std::string name = sent.substr(std::min(sent.find_last_of("/\\") + 1, sent.size()));
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || std::string_view("*?[]$").find(c) != std::string_view::npos)
      c = '_';
  name.erase(0, std::min(name.find_first_not_of('.'), name.size()));
  return name;
}

using Open = std::function<void(Document, bool discard, httplib::Response&)>;

void add_bundle_routes(LocalServer& server, LiveGraph& live, const Registry& registry,
                       const StudioStart& start, const Open& open) {
  using In = httplib::Request;
  using Out = httplib::Response;
  auto& http = server.http();
  http.Get("/api/bundle_picture", server.handler([&start](const In& in, const json&, Out& out) {
    const auto bytes = read_bundle_preview(start.workspace.resolve(in.get_param_value("file")));
    if (!bytes) throw Error("no-file", "the bundle has no picture");
    out.set_content(*bytes, bytes->starts_with("\x89PNG") ? "image/png" : "image/jpeg");
  }));
  // A bundle that was dropped on the page: it is kept in the folder of the Studio, and opened there.
  http.Post("/api/bundle",
            server.upload_handler([&start, &live, &registry, open](const In& in, const json&, Out& out) {
              const bool discard = in.get_param_value("discard") == "true";
              if (!discard) live.require_saved();
              const fs::path name = file_name(in.get_param_value("name"));
              if (name.extension() != ".zip" || name.stem().empty())
                throw Error("bad-bundle", "'" + name.string() + "' is no bundle", "its name ends in .zip");
              const NewFile file = write_once(start.workspace.resolve(name.string()), in.body);
              try {
                open(Document(graph_of_bundle(file.path, file.path.parent_path(), registry)), discard, out);
              } catch (const Error&) {
                std::error_code error;
                if (file.written) fs::remove(file.path, error);
                throw;
              }
            }));
  http.Post("/api/share", server.handler([&](const In&, const json& body, Out& out) {
    fs::path file = start.workspace.resolve(body.at("file").get<std::string>());
    if (file.extension() != ".zip") file += ".zip";
    if (fs::exists(fs::symlink_status(file)))
      throw Error("file-exists", "'" + file.string() + "' exists already", "choose another name");
    BundleRequest request = live.bundle_request();
    request.license = body.value("license", "");
    request.source = body.value("source", "");
    const TemporaryFolder pictures(fs::temp_directory_path());
    if (const std::string picture = body.value("picture", ""); !picture.empty()) {
      request.preview = pictures.path() / "preview.png";
      write_image(request.preview, live.value(picture).as<Image>());
    }
    write_bundle(file, request, registry);
    LocalServer::answer(out, {{"file", file.string()}});
  }));
}

}  // namespace

void add_start_routes(LocalServer& server, LiveGraph& live, const Registry& registry,
                      const StudioStart& start) {
  using In = httplib::Request;
  using Out = httplib::Response;
  auto& http = server.http();
  const auto welcome = std::make_shared<std::atomic<bool>>(start.welcome);
  const Open open = [&live, &start, welcome](Document document, bool discard, Out& out) {
    const std::string file = document.file().string();
    live.open(std::move(document), discard, *welcome ? std::optional(start.live) : std::nullopt);
    *welcome = false;
    LocalServer::answer(out, {{"file", file}});
  };
  add_bundle_routes(server, live, registry, start, open);
  http.Get("/api/start", server.handler([&start, welcome](const In&, const json&, Out& out) {
    json list = json::array();
    for (const auto& m : materials())
      list.push_back({{"name", m.name}, {"title", m.title}, {"doc", m.doc}, {"picture", !m.picture.empty()}});
    json graphs = json::array(), bundles = json::array();
    const OwnFiles own = own_files(start.workspace);
    for (const auto& g : own.graphs)
      if (find_invalid_utf8(g.file) == std::string::npos)
        graphs.push_back({{"file", g.file}, {"changed", g.changed}});
    for (const auto& b : own.bundles)
      if (find_invalid_utf8(b.file) == std::string::npos)
        bundles.push_back({{"file", b.file}, {"title", b.title}, {"doc", b.doc}, {"picture", b.picture}});
    LocalServer::answer(out, {{"welcome", welcome->load()},
                              {"folder", start.workspace.folder().string()},
                              {"materials", list},
                              {"graphs", graphs},
                              {"bundles", bundles}});
  }));
  http.Get("/api/picture/([a-z0-9_]{1,80})", server.handler([](const In& in, const json&, Out& out) {
    const auto bytes = read_file(material(in.matches[1]).picture);
    if (!bytes) throw Error("no-file", "the material has no picture");
    out.set_content(*bytes, "image/jpeg");
  }));
  http.Post("/api/open",
            server.handler([&start, &live, &registry, open](const In&, const json& body, Out& out) {
              if (body.contains("bundle")) {
                const bool discard = body.value("discard", false);
                if (!discard) live.require_saved();
                const fs::path bundle = start.workspace.resolve(body["bundle"].get<std::string>());
                return open(Document(graph_of_bundle(bundle, bundle.parent_path(), registry)), discard, out);
              }
              if (body.contains("graph")) {
                const fs::path file = start.workspace.resolve(body["graph"].get<std::string>());
                return open(Document(file), body.value("discard", false), out);
              }
              const Material m = material(body.at("material").get<std::string>());
              open(Document(m.file, true), body.value("discard", false), out);
            }));
  http.Post(
      "/api/photograph", server.upload_handler([&start, &live, open](const In& in, const json&, Out& out) {
        const bool discard = in.get_param_value("discard") == "true";
        if (!discard) live.require_saved();
        const std::string name = file_name(in.get_param_value("name"));
        const fs::path folder = start.workspace.resolve(in.get_param_value("folder"));
        start.workspace.resolve((folder / name).lexically_relative(start.workspace.folder()).string());
        Settings settings;
        if (in.has_param("pixel_size")) {
          const std::string text = in.get_param_value("pixel_size");
          double size = 0;
          const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
          if (error != std::errc() || end != text.data() + text.size() || !(size >= 1e-6 && size <= 1e6))
            throw Error("bad-value", "the size of a pixel is not a number of mm from 0.000001 to 1,000,000");
          settings.emplace_back("pixel_size", text);
        }
        const std::string content = in.has_param("content") ? in.get_param_value("content") : "particles";
        if (content != "particles" && content != "phases")
          throw Error("bad-value", "the content '" + content + "' is neither 'particles' nor 'phases'");
        open(Document(create_graph(in.body, name, folder,
                                   content == "phases" ? Content::Phases : Content::Particles, settings)
                          .path),
             discard, out);
      }));
  // A file for the graph that is open, written beside it.
  http.Post("/api/input", server.upload_handler([&start, &live](const In& in, const json&, Out& out) {
    const fs::path folder = live.file_of(in.get_param_value("scope")).parent_path();
    const fs::path named = folder / file_name(in.get_param_value("name"));
    const fs::path file =
        start.workspace.resolve(named.lexically_relative(start.workspace.folder()).string());
    LocalServer::answer(out, {{"file", write_once(file, in.body).path.filename().string()}});
  }));
  http.Post("/api/recommend", server.upload_handler([](const In& in, const json&, Out& out) {
    const auto found = recommend(in.body, file_name(in.get_param_value("name")));
    LocalServer::answer(out, {{"content", found.phases ? "phases" : "particles"}, {"why", found.why}});
  }));
  http.Post("/api/save_as", server.handler([&](const In&, const json& body, Out& out) {
    fs::path file = start.workspace.resolve(body.at("file").get<std::string>());
    if (file.extension() != ".yaml" && file.extension() != ".yml") file += ".yaml";
    live.change([&](Document& d) {
      d.save_as(file, relocated(d.text(), d.file(), file, start.workspace, registry));
    });
    LocalServer::answer(out, {{"file", file.string()}});
  }));
}

}  // namespace terrazzo::studio
