#include "runtime/clients/studio/server/graph_routes.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "graph/document/paste_nodes.h"
#include "graph/graph.h"
#include "graph/text/element_name.h"
#include "graph/text/read_number.h"
#include "runtime/clients/studio/live/collapse_nodes.h"
#include "runtime/clients/studio/live/expand_subgraph.h"
#include "runtime/clients/studio/live/graph_parameter.h"
#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/json_text.h"

#include "runtime/clients/studio/server/local_server.h"  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {
using nlohmann::json;
namespace {

WrittenValue written_value(const json& j) {
  const auto word = [](const json& x) { return x.is_string() ? x.get<std::string>() : json_text(x); };
  WrittenValue v{j.is_array(), {}, {}};
  if (!j.is_array()) {
    v.items.push_back(word(j));
    return v;
  }
  for (const auto& x : j) v.items.push_back(word(x));
  return v;
}

Edit edit_of(const json& j) {
  static const std::map<std::string, Edit::Kind> kinds = {{"set", Edit::Kind::SetParameter},
                                                          {"reset", Edit::Kind::ResetParameter},
                                                          {"append", Edit::Kind::AppendItem},
                                                          {"remove_item", Edit::Kind::RemoveItem},
                                                          {"set_default", Edit::Kind::SetDefault},
                                                          {"connect", Edit::Kind::Connect},
                                                          {"rewire", Edit::Kind::Rewire},
                                                          {"bypass", Edit::Kind::SetBypass},
                                                          {"add", Edit::Kind::AddNode},
                                                          {"remove", Edit::Kind::RemoveNode},
                                                          {"rename", Edit::Kind::RenameNode}};
  const auto kind = kinds.find(j.at("op").get<std::string>());
  if (kind == kinds.end())
    throw Error("bad-request", "there is no edit '" + j["op"].get<std::string>() + "'");
  Edit e;
  e.kind = kind->second;
  e.node = j.value("node", "");
  e.name = j.value("name", "");
  e.to = j.value("to", "");
  e.type = j.value("type", "");
  e.graph = j.value("graph", "");
  e.index = j.value("index", std::size_t{0});
  e.bypass = j.value("bypass", false);
  if (j.contains("value")) e.value = written_value(j["value"]);
  if (j.contains("wires")) e.wires = j["wires"].get<std::vector<std::string>>();
  const bool needs_value = e.kind == Edit::Kind::SetParameter || e.kind == Edit::Kind::AppendItem ||
                           e.kind == Edit::Kind::SetDefault;
  if (needs_value && !j.contains("value")) throw Error("bad-request", "the edit has no value");
  return e;
}

// Sends a file piece by piece: grids may be larger than memory. The page names the download.
void send_file(const std::filesystem::path& path, httplib::Response& out) {
  const auto file = std::make_shared<std::ifstream>(path, std::ios::binary);
  out.set_content_provider(std::filesystem::file_size(path), "application/octet-stream",
                           [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                             std::string piece(std::min(length, std::size_t{1} << 16), '\0');
                             file->seekg(static_cast<std::streamoff>(offset));
                             file->read(piece.data(), static_cast<std::streamsize>(piece.size()));
                             return *file && sink.write(piece.data(), piece.size());
                           });
}

// Changes the document, or the file of the subgraph that the page shows.
template <class Change>
void change(LiveGraph& live, const json& body, Change&& apply) {
  live.change(std::forward<Change>(apply), scope_of(body));
}

// Makes a subgraph of nodes, in a new file beside the graph, which stays when this is undone.
void collapse(Document& d, const json& body, const Registry& registry) {
  const std::string name = body.at("name").get<std::string>();
  if (d.read_only() || !is_node_name(name))
    throw Error("cannot-edit",
                d.read_only() ? "the graph belongs to the program, so it gets no subgraph of its own"
                              : "'" + name + "' is not a name",
                d.read_only() ? "save it as a file of your own" : "use letters, digits and _");
  SaveFile place = SaveFile::numbered(d.file().parent_path() / (name + ".yaml"));
  NewSubgraph made = collapse_nodes(d.read(), d.file(), body.at("nodes").get<std::vector<std::string>>(),
                                    name, place.path().filename().string());
  if (place.write([&](const std::filesystem::path&) { return made.subgraph; }))
    throw Error("file-changed", "another program wrote to the subgraph's file", "try again");
  Diagnostics before, found;
  load_graph_text(made.graph, d.file(), registry, {}, found);
  load_graph_text(d.text(), d.file(), registry, {}, before);
  if (has_errors(found) && !has_errors(before)) {
    std::error_code error;
    std::filesystem::remove(place.path(), error);
    throw Error(found.front());
  }
  d.replace(std::move(made.graph), places_of(body));
}

}  // namespace

std::vector<Edit> edits_of(const json& list) {
  std::vector<Edit> edits;
  for (const auto& e : list) edits.push_back(edit_of(e));
  return edits;
}

std::string scope_of(const json& body) { return body.is_object() ? body.value("scope", "") : ""; }

Places places_of(const json& body) { return body.value("places", Places()); }

void add_graph_routes(LocalServer& server, LiveGraph& live, const Registry& registry) {
  using In = httplib::Request;
  using Out = httplib::Response;
  auto& http = server.http();
  http.Post("/api/price", server.handler([&live](const In&, const json& body, Out& out) {
    LocalServer::answer(out, live.price(edits_of(body.at("edits")), scope_of(body)));
  }));
  http.Post("/api/paste", server.handler([&live](const In&, const json& body, Out& out) {
    json names = json::array();
    change(live, body, [&](Document& d) {
      Pasted p = paste_nodes(d.text(), d.file(), body.at("text").get<std::string>());
      const Places given = places_of(body);
      Places places;
      for (const auto& [copied, now] : p.names) {
        names.push_back(now);
        if (const auto it = given.find(copied); it != given.end()) places[now] = it->second;
      }
      d.replace(std::move(p.text), places);
    });
    LocalServer::answer(out, {{"number", live.events().last()}, {"names", names}});
  }));
  http.Post("/api/promote", server.handler([&live, &registry](const In&, const json& body, Out& out) {
    std::string name;
    change(live, body, [&](Document& d) {
      NewGraphParameter made =
          with_graph_parameter(d.read(), d.file(), registry, body.at("node").get<std::string>(),
                               body.at("name").get<std::string>());
      name = made.name;
      d.replace(std::move(made.text));
    });
    LocalServer::answer(out, {{"number", live.events().last()}, {"name", name}});
  }));
  http.Post("/api/expand", server.handler([&live, &registry](const In&, const json& body, Out& out) {
    change(live, body, [&](Document& d) {
      d.replace(expand_subgraph(d.read(), d.file(), body.at("node").get<std::string>(), registry));
    });
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Post("/api/collapse", server.handler([&live, &registry](const In&, const json& body, Out& out) {
    change(live, body, [&](Document& d) { collapse(d, body, registry); });
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Get("/api/history", server.handler([&live](const In& in, const json&, Out& out) {
    LocalServer::answer(out, live.history(in.get_param_value("node"), in.get_param_value("port")));
  }));
  http.Get("/api/history/([0-9]{1,9})", server.handler([&live](const In& in, const json&, Out& out) {
    LocalServer::answer(out, live.past(number_in_text<std::size_t>(in.matches[1].str()).value_or(0)));
  }));
  http.Post("/api/restore", server.handler([&live](const In&, const json& body, Out& out) {
    live.restore(body.at("number").get<std::size_t>());
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Post("/api/variants", server.handler([&live](const In&, const json& body, Out& out) {
    live.vary({.target = body.at("target").get<std::string>(),
               .values = body.at("values").get<std::string>(),
               .node = body.at("node").get<std::string>(),
               .port = body.at("port").get<std::string>(),
               .scope = scope_of(body)});
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Post("/api/variants/cancel", server.handler([&live](const In&, const json&, Out& out) {
    live.cancel_variants();
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Post("/api/variants/keep", server.handler([&live](const In&, const json& body, Out& out) {
    live.keep_variant(body.at("tile").get<std::size_t>());
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
  http.Get("/api/subgraph", server.handler([&live](const In& in, const json&, Out& out) {
    LocalServer::answer(out, live.subgraph(in.get_param_value("path")));
  }));
  http.Get("/api/files", server.handler([&live](const In&, const json&, Out& out) {
    LocalServer::answer(out, live.files());
  }));
  http.Get("/api/outputs", server.handler([&live](const In&, const json&, Out& out) {
    LocalServer::answer(out, live.outputs());
  }));
  http.Get("/api/output", server.handler([&live](const In& in, const json&, Out& out) {
    send_file(live.output(in.get_param_value("path")), out);
  }));
  http.Post("/api/arrange", server.handler([&live](const In&, const json& body, Out& out) {
    live.arrange(body.at("arrangement"), body.value("group", ""), scope_of(body));
    LocalServer::answer(out, {{"number", live.events().last()}});
  }));
}

}  // namespace terrazzo::studio
