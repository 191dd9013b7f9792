#include "runtime/sweep/sweep_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "graph/input_file.h"
#include "runtime/files.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"
#include "runtime/report/provenance.h"
#include "runtime/report/report_format.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kSweepFormat = 2;

json sweep_json(const SweepFile& s) {
  json vary = json::array(), parts = json::array();
  for (const auto& v : s.points.vary()) vary.push_back({{"target", v.target}, {"values", v.values}});
  for (const auto& p : s.points.parts()) parts.push_back({{"name", p.name}, {"targets", p.targets}});
  return {{"terrazzo_sweep", kSweepFormat},
          {"folder", s.folder},
          {"graph", s.graph},
          {"targets", s.targets},
          {"vary", vary},
          {"parts", parts},
          {"set", s.points.common().set},
          {"parameters", s.points.common().parameters},
          {"program", s.program},
          {"versions", s.versions},
          {"files", s.files},
          {"shared", s.shared}};
}

}  // namespace

Hash SweepFile::hash() const { return hash_of(json_text(sweep_json(*this))); }

ProtectedFiles protected_files(const SweepFile& sweep) {
  ProtectedFiles out;
  for (const auto& [path, content] : sweep.files) out.add(path);
  return out;
}

void write_sweep_file(const fs::path& path, const SweepFile& sweep) {
  write_text_atomically(path, protected_files(sweep), json_text(sweep_json(sweep), 1) + "\n");
}

SweepFile read_sweep_file(const fs::path& path) {
  const auto bad = [&](const std::string& why) -> Error {
    return Error("sweep-file", fmt::format("cannot use '{}' as a sweep: {}", path.string(), why),
                 "`terrazzo sweep` writes sweep.json into its output folder");
  };
  const FileText file = read_input_file(path, kMostTextBytes);
  if (!file) throw bad(file.trouble);
  json j;
  try {
    j = parse_json(file.text);
  } catch (const Error& e) {
    throw bad(e.diagnostic().message);
  }
  try {
    if (const int format = j.at("terrazzo_sweep"); format != kSweepFormat)
      throw bad(fmt::format("it has format {}, and this program reads format {}", format, kSweepFormat));
    using Settings = std::vector<std::pair<std::string, std::string>>;
    SweepFile out;
    out.folder = j.at("folder");
    out.graph = j.at("graph");
    out.targets = j.at("targets").get<std::vector<std::string>>();
    std::vector<Vary> vary;
    for (const auto& v : j.at("vary"))
      vary.push_back({v.at("target"), v.at("values").get<std::vector<std::string>>()});
    std::vector<GraphPart> parts;
    for (const auto& p : j.at("parts")) {
      parts.push_back({p.at("name"), p.at("targets").get<std::vector<std::string>>()});
      if (parts.back().targets.empty()) throw bad(fmt::format("part '{}' has no targets", parts.back().name));
    }
    if (parts.empty() == vary.empty()) throw bad("it has neither values nor parts, or both");
    Overrides common{j.at("set").get<Settings>(), j.at("parameters").get<Settings>(), {}};
    out.points = parts.empty() ? SweepPoints(std::move(vary), std::move(common))
                               : SweepPoints::of_parts(std::move(parts), std::move(common));
    out.program = j.at("program");
    out.versions = j.at("versions").get<std::map<std::string, int>>();
    out.files = j.at("files").get<std::map<std::string, std::string>>();
    out.shared = j.at("shared").get<std::vector<std::string>>();
    return out;
  } catch (const json::exception& e) {
    throw bad(json_problem(e));
  }
}

void require_same_version(const SweepFile& sweep, const Registry& registry) {
  const auto refuse = [](const std::string& what) {
    throw Error("other-version", what, "install the same version on all machines, or plan the sweep again");
  };
  if (sweep.program != program_version)
    refuse(fmt::format("this is terrazzo {}, but the sweep was planned with {}", program_version,
                       sweep.program));
  for (const auto& [name, version] : sweep.versions) {
    const NodeType* type = registry.find(name);
    if (!type) refuse(fmt::format("node type '{}' of the sweep is not available here", name));
    if (type->version != version)
      refuse(fmt::format("node type '{}' has version {} here, but the sweep was planned with version {}",
                         name, type->version, version));
  }
}

namespace {

[[noreturn]] void input_changed(const std::string& path, const char* what) {
  throw Error("input-changed", fmt::format("'{}' {} since the sweep was planned", path, what),
              "restore the file, or run `terrazzo sweep` again to plan the sweep with the new content");
}

}  // namespace

void require_same_files(const SweepFile& sweep, FileHashes& hashes) {
  for (const auto& [path, content] : sweep.files) {
    const auto now = hashes.hash(path);
    if (!now) input_changed(path, "has disappeared or become unreadable");
    if (now->text() != content) input_changed(path, "has changed");
  }
}

void require_same_reads(const SweepFile& sweep, const json& report) {
  for (const auto& node : report.at("nodes"))
    for (const auto& file : node.at("reads")) {
      const std::string path = fs::absolute(file.at("path").get<std::string>()).lexically_normal().string();
      const auto planned = sweep.files.find(path);
      if (planned == sweep.files.end()) input_changed(path, "has appeared");
      if (planned->second != file.at("content")) input_changed(path, "has changed");
    }
}

bool is_finished_point(const json& report, const Hash& sweep, const fs::path& folder) {
  try {
    if (report.at("sweep") != sweep.text() || summary_of(report).status != "done") return false;
    std::error_code error;
    for (const auto& node : report.at("nodes"))
      for (const auto& file : node.at("files"))
        if (!fs::exists(folder / file.at("path").get<std::string>(), error)) return false;
    return true;
  } catch (const json::exception&) {
    return false;  // of an earlier version, or not a report
  }
}

bool is_in_cache(const SweepPoint& point, const json& report, Store& store) {
  if (point.targets.empty()) return true;
  try {
    std::map<std::string, const json*> nodes;
    for (const auto& node : report.at("nodes")) nodes[node.at("name")] = &node;
    for (const auto& target : point.targets) {
      const auto node = nodes.find(target);
      if (node == nodes.end()) return false;
      Tier tier;
      const auto record = store.find_action(Hash::parse(node->second->at("key").get<std::string>()), tier);
      if (!record) return false;
      for (const auto& [port, output] : record->outputs)
        if (!store.has_value(output)) return false;
    }
    return true;
  } catch (const json::exception&) {
    return false;
  }
}

json read_shared_report(const SweepFile& sweep, const fs::path& out) {
  json report = read_report(shared_report(out));
  return is_finished_point(report, sweep.hash(), out) ? report : json();
}

bool is_shared_in_cache(const SweepFile& sweep, const json& shared_report, Store& store) {
  SweepPoint point;
  point.targets = sweep.shared;
  return shared_report.is_object() && is_in_cache(point, shared_report, store);
}

}  // namespace terrazzo
