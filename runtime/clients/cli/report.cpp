#include "runtime/clients/cli/report.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "graph/document/write_graph.h"
#include "graph/text/utf8.h"
#include "runtime/given.h"
#include "runtime/json_text.h"
#include "runtime/report/report_format.h"

namespace terrazzo::cli {
using nlohmann::json;

std::string bytes_text(std::uint64_t b) {
  if (b < 1000) return fmt::format("{} B", b);
  double v = b;
  const char* units[] = {"B", "kB", "MB", "GB", "TB"};
  int u = 0;
  while (v >= 1000 && u < 4) {
    v /= 1000;
    ++u;
  }
  return fmt::format("{:.1f} {}", v, units[u]);
}

json report_json(const Graph& graph, const RunResult& run, int threads, const Overrides& overrides,
                 const std::filesystem::path& folder) {
  struct rusage usage;
  ::getrusage(RUSAGE_SELF, &usage);
  json nodes = json::array();
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const NodeResult& r = run.nodes[i];
    if (r.status == Status::Unneeded) continue;
    json outputs = json::object();
    json metrics = json::object();
    json files = json::array();
    for (const auto& [port, o] : r.outputs)
      outputs[port] = {{"type", o.type}, {"content", o.content.text()}, {"bytes", o.bytes}};
    for (const auto& [name, v] : r.metrics) metrics[name] = v;
    for (const auto& f : r.files) files.push_back({{"path", f.path}, {"content", f.content.text()}});
    json reads = json::array();
    for (const auto& f : r.read) reads.push_back({{"path", f.path}, {"content", f.content.text()}});
    json error = nullptr;
    if (r.error)
      error = {{"code", r.error->code},          {"message", r.error->message},
               {"hint", r.error->hint},          {"file", r.error->place.file},
               {"line", r.error->place.line},    {"column", r.error->place.column},
               {"parameter", r.error->parameter}};
    nodes.push_back({{"name", graph.nodes[i].path},
                     {"type", graph.nodes[i].type->name},
                     {"status", name_of(r.status)},
                     {"seconds", r.seconds},
                     {"key", r.key.text()},
                     {"error", error},
                     {"outputs", outputs},
                     {"metrics", metrics},
                     {"warnings", r.warnings},
                     {"files", files},
                     {"reads", reads}});
  }
  std::vector<bool> needed;
  for (const auto& r : run.nodes) needed.push_back(r.status != Status::Unneeded && !r.tolerated);
  json set = json::object();
  for (const auto& [name, value] : overrides.set) set[name] = value;
  for (const auto& [name, value] : overrides.parameters) set[name] = value;
  json report = {{"format", kReportFormat},
                 {"graph", graph.file},
                 {"set", set},
                 {"document", write_graph(graph, needed, folder.empty() ? "." : folder)},
                 {"seconds", run.seconds},
                 {"threads", threads},
                 {"peak_bytes", static_cast<std::uint64_t>(usage.ru_maxrss) * 1024},
                 {"nodes", nodes}};
  if (json values = given_values_json(graph, needed); !values.empty()) report["values"] = std::move(values);
  return report;
}

void print_table(std::ostream& out, const Graph& graph, const RunResult& run) {
  std::size_t width = 4;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    if (run.nodes[i].status != Status::Unneeded) width = std::max(width, graph.nodes[i].path.size());
  out << fmt::format("{:<{}}  {:<9} {:>9} {:>10}\n", "node", width, "status", "seconds", "bytes");
  std::size_t computed = 0, cached = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const NodeResult& r = run.nodes[i];
    if (r.status == Status::Unneeded) continue;
    computed += r.status == Status::Computed;
    cached += r.status == Status::Memory || r.status == Status::Disk;
    std::uint64_t bytes = 0;
    for (const auto& [port, o] : r.outputs) bytes += o.bytes;
    const bool is_cached = r.status == Status::Memory || r.status == Status::Disk;
    out << fmt::format("{:<{}}  {:<9} {:>9} {:>10}\n", graph.nodes[i].path, width,
                       is_cached ? "cached" : name_of(r.status),
                       r.status == Status::Computed ? fmt::format("{:.2f}", r.seconds) : "",
                       r.outputs.empty() ? "" : bytes_text(bytes));
  }
  out << fmt::format("{} computed, {} cached, {:.2f} s\n", computed, cached, run.seconds);
}

void print_metrics(std::ostream& out, const Graph& graph, const RunResult& run) {
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const auto& metrics = run.nodes[i].metrics;
    if (metrics.empty()) continue;
    std::string line = graph.nodes[i].path + ":";
    const char* between = " ";
    for (const auto& [name, v] : metrics) {
      line += fmt::format("{}{} {:.4g}", between, name, v);
      between = ", ";
    }
    out << line << '\n';
  }
}

void print_stacks(std::ostream& out, const Graph& graph, const RunResult& run) {
  const auto name = [](const FileRecord& f) { return std::filesystem::path(f.path).filename().string(); };
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    if (const auto& read = run.nodes[i].read; read.size() > 1)
      out << fmt::format("{}: reads {} files, first '{}', last '{}'\n", graph.nodes[i].path, read.size(),
                         name(read.front()), name(read.back()));
}

namespace {

std::string cell_text(const json& v) {
  if (v.is_string()) return escape_line(v.get<std::string>());
  if (v.is_number_float()) return fmt::format("{:.5g}", v.get<double>());
  return json_text(v);
}

std::string table_text(const json& table) {
  std::vector<std::vector<std::string>> cells(1);
  for (const auto& c : table.at("columns")) cells[0].push_back(cell_text(c));
  for (const auto& row : table.at("rows")) {
    cells.emplace_back();
    for (const auto& v : row) cells.back().push_back(cell_text(v));
  }
  std::vector<std::size_t> width(cells[0].size(), 0);
  for (const auto& row : cells)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string out;
  for (const auto& row : cells) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c)
      line += fmt::format("{}{:<{}}", c ? "  " : "", row[c], width[c]);
    out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return out;
}

void lines(const std::string& indent, const json& v, std::string& out) {
  for (const auto& [key, x] : v.items()) {
    if (x.is_object()) {
      out += indent + key + ":\n";
      lines(indent + "  ", x, out);
    } else if (x.is_array() && !x.empty() && (x[0].is_object() || x[0].is_array())) {
      out += fmt::format("{}{}: {} entries\n", indent, key, x.size());
      for (std::size_t i = 0; i < std::min<std::size_t>(x.size(), 12); ++i) {
        std::string row = json_text(x[i]);
        if (row.size() > 160) row = row.substr(0, 160) + "…";
        out += indent + "  " + row + "\n";
      }
      if (x.size() > 12) out += indent + "  …\n";
    } else {
      std::string text = cell_text(x);
      if (text.size() > 200) text = text.substr(0, 200) + "…";
      out += indent + key + ": " + text + "\n";
    }
  }
}

}  // namespace

std::string readable(const std::string& type, const json& v) {
  if (type == "Table" && v.contains("columns")) return table_text(v);
  std::string out;
  lines("", v, out);
  return out;
}

}  // namespace terrazzo::cli
