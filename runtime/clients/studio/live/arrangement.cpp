#include "runtime/clients/studio/live/arrangement.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr std::size_t kMostArrangement = 1 << 20;

bool is_number(const json& j) { return j.is_number() && std::isfinite(j.get<double>()); }

bool is_place(const json& j) { return j.is_array() && j.size() == 2 && is_number(j[0]) && is_number(j[1]); }

bool is_note(const json& j) {
  if (!j.is_object()) return false;
  for (const char* name : {"x", "y", "width", "height"})
    if (!j.contains(name) || !is_number(j[name])) return false;
  return j.contains("text") && j["text"].is_string() && j.contains("frame") && j["frame"].is_boolean();
}

// The file may come from a stranger, so the page gets nothing else.
bool is_arrangement(const json& j) {
  if (!j.is_object()) return false;
  for (const auto& [name, part] : j.items()) {
    const auto all = [&](auto&& check) {
      for (const auto& x : part)
        if (!check(x)) return false;
      return true;
    };
    const bool good = name == "places" ? part.is_object() && all(is_place)
                                       : name == "notes" && part.is_array() && all(is_note);
    if (!good) return false;
  }
  return true;
}

}  // namespace

fs::path arrangement_file(const fs::path& graph) {
  return graph.parent_path() / (graph.filename().string() + ".studio.json");
}

namespace {

// Earlier versions named it without the extension of the graph, so "a.yaml" and "a.yml" had one.
fs::path former_file(const fs::path& graph) {
  return graph.parent_path() / (graph.stem().string() + ".studio.json");
}

// Whether another graph has the same former file.
bool shares_former_file(const fs::path& graph) {
  std::error_code error;
  for (const char* extension : {"", ".yaml", ".yml"}) {
    const fs::path other = graph.parent_path() / (graph.stem().string() + extension);
    if (other != graph && fs::exists(other, error)) return true;
  }
  return false;
}

// The text in a file; "" if there is none, nothing if the file is no arrangement.
std::optional<std::string> arrangement_in(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(file, error))) return "";
  const FileText text = read_input_file(file, kMostArrangement);
  if (!text) return {};
  const json j = json_or_null(text.text);
  if (!is_arrangement(j)) return {};
  return arrangement_text(j);  // written anew, so that equal arrangements have equal texts
}

}  // namespace

std::string arrangement_text(const json& j) {
  if (!is_arrangement(j)) throw Error("bad-request", "this is not an arrangement of a graph");
  json kept = json::object();
  for (const auto& [name, part] : j.items())
    if (!part.empty()) kept[name] = part;
  if (kept.empty()) return {};
  std::string text = json_text(kept, 1) + "\n";
  if (text.size() > kMostArrangement)
    throw Error("too-large", "the notes and places of the graph have more than 1 MiB");
  return text;
}

json arrangement_json(const std::string& text) {
  json j = json_or_null(text);
  return is_arrangement(j) ? j : json::object();
}

std::string arrangement_placed(const std::string& text, const Places& places) {
  if (places.empty()) return text;
  json j = arrangement_json(text);
  for (const auto& [node, at] : places) j["places"][node] = at;
  return arrangement_text(j);
}

std::string arrangement_renamed(const std::string& text, const std::string& from, const std::string& to) {
  json j = arrangement_json(text);
  if (!j.contains("places") || !j["places"].contains(from)) return text;
  json& places = j["places"];
  places[to] = places[from];
  places.erase(from);
  return arrangement_text(j);
}

std::optional<std::string> read_arrangement(const fs::path& graph) {
  const fs::path file = arrangement_file(graph);
  std::error_code error;
  if (fs::exists(fs::symlink_status(file, error))) return arrangement_in(file);
  return arrangement_in(former_file(graph)).value_or("");  // another file of that name stays unused
}

void write_arrangement(const fs::path& graph, const std::string& text) {
  const fs::path file = arrangement_file(graph);
  const fs::path former = former_file(graph);
  if (!read_arrangement(graph))
    throw Error("file-exists",
                "'" + file.string() + "' is not an arrangement of this graph, so it stays unchanged",
                "rename that file to keep notes and places");
  std::error_code error;
  const bool had_former = former != file && !arrangement_in(former).value_or("").empty();
  const bool keep_former = had_former && shares_former_file(graph);
  if (!text.empty())
    save_text(file, text, graph);
  else if (keep_former)
    save_text(file, "{}\n", graph);  // so that the shared one is not read again
  else
    fs::remove(file, error);
  if (had_former && !keep_former) fs::remove(former, error);
}

}  // namespace terrazzo::studio
