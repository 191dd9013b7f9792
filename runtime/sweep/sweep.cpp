#include "runtime/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>

#include "graph/text/utf8.h"
#include "graph/value_range.h"
#include "runtime/files/json_input.h"
#include "runtime/report/report_format.h"

namespace terrazzo {
namespace {

[[noreturn]] void bad(const std::string& text, const std::string& why) {
  throw Error("usage", fmt::format("--vary '{}': {}", text, why),
              "write NODE.PARAM=A,B,C or NODE.PARAM=LO:HI:STEP");
}

// Splits at a separator, except inside brackets or quotes.
std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> out(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote)
      quote = c == quote ? 0 : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else
      depth += (c == '[') - (c == ']');
    if (c == at && depth == 0 && !quote)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

std::string csv_cell(const std::string& s) {
  const std::string text = escape_controls(s);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace

std::vector<std::string> parse_values(const std::string& text) {
  const auto refused = [](const std::string& why) {
    return Error("usage", "the list " + why, "write A,B,C or LO:HI:STEP");
  };
  if (find_invalid_utf8(text) != std::string::npos) throw refused("is not UTF-8");
  if (text.find_first_not_of(" \t") == std::string::npos) throw refused("has no values");
  try {
    if (auto range = read_range(text, 100000)) return *range;
  } catch (const Error& e) {
    throw Error("usage", e.diagnostic().message, e.diagnostic().hint);
  }
  auto values = split(text, ',');
  for (auto& v : values) {
    v.erase(0, v.find_first_not_of(' '));
    if (v.empty()) throw refused("has an empty value");
    v.erase(v.find_last_not_of(' ') + 1);
  }
  return values;
}

Vary parse_vary(const std::string& text) {
  if (find_invalid_utf8(text) != std::string::npos) bad(valid_utf8(text), "is not UTF-8");
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) bad(text, "has no values");
  try {
    return {text.substr(0, equals), parse_values(text.substr(equals + 1))};
  } catch (const Error& e) {
    bad(text, e.diagnostic().message);
  }
}

SweepPoints::SweepPoints(std::vector<Vary> vary, Overrides common)
    : vary_(std::move(vary)), common_(std::move(common)), size_(1) {
  std::set<std::string> targets;
  for (const auto& v : vary_) {
    if (!targets.insert(v.target).second) throw Error("usage", "'" + v.target + "' is varied twice");
    size_ *= v.values.size();
    if (size_ > 100000) throw Error("usage", "the sweep has more than 100,000 points");
  }
  width_ = std::max<std::size_t>(3, std::to_string(size_).size());
}

SweepPoints SweepPoints::of_parts(std::vector<GraphPart> parts, Overrides common) {
  SweepPoints out;
  out.size_ = parts.size();
  out.width_ = std::max<std::size_t>(3, std::to_string(parts.size()).size());
  out.parts_ = std::move(parts);
  out.common_ = std::move(common);
  return out;
}

std::string SweepPoint::caption() const {
  std::string out = folder;
  const char* between = ": ";
  for (const auto& [target, value] : values) {
    out += between + target + " " + value;
    between = ", ";
  }
  return out;
}

std::string SweepPoint::name() const { return targets.empty() ? folder : values.front().second; }

SweepPoint SweepPoints::operator[](std::size_t i) const {
  SweepPoint p;
  p.index = i + 1;
  p.folder = fmt::format("point-{:0{}}", i + 1, width_);
  p.overrides = common_;
  if (!parts_.empty()) {
    p.values = {{"element", parts_[i].name}};
    p.targets = parts_[i].targets;
    return p;
  }
  std::size_t rest = i;
  p.values.resize(vary_.size());
  for (std::size_t k = vary_.size(); k-- > 0;) {
    p.values[k] = {vary_[k].target, vary_[k].values[rest % vary_[k].values.size()]};
    rest /= vary_[k].values.size();
  }
  for (const auto& value : p.values)
    (value.first.find('.') == std::string::npos ? p.overrides.parameters : p.overrides.set).push_back(value);
  return p;
}

std::optional<std::size_t> SweepPoints::find(const std::string& name) const {
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].name == name) return i;
  const std::string digits = name.starts_with("point-") ? name.substr(6) : name;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc() || end != digits.data() + digits.size() || index == 0 || index > size_) return {};
  return index - 1;
}

PointRange points_of(std::size_t chunk, std::size_t chunks, std::size_t points) {
  // The first chunks have one point more. Unlike chunk · points / chunks, this cannot overflow.
  const std::size_t size = points / chunks, larger = points % chunks;
  const auto start = [&](std::size_t k) { return k * size + std::min(k, larger); };
  return {start(chunk), start(chunk + 1)};
}

PointSummary summary_of(const nlohmann::json& report) {
  PointSummary out;
  out.seconds = report.at("seconds").get<double>();
  for (const auto& node : report.at("nodes")) {
    const auto& status = node.at("status");
    out.computed += status == "computed";
    out.cached += status == "memory" || status == "disk";
    if (status == "failed" || status == "cancelled") out.status = status;
    if (const auto error = node.find("error"); error != node.end() && !error->is_null()) {
      out.errors.push_back(node.at("name").get<std::string>() + ": " +
                           error->at("message").get<std::string>());
      out.cannot_write = out.cannot_write || error->at("code") == "write-failed";
    }
  }
  return out;
}

namespace {

bool has_text(const nlohmann::json& j, const char* name) {
  const auto it = j.find(name);
  return it != j.end() && it->is_string();
}

// Whether there is a list of objects with a path and a content.
bool has_files(const nlohmann::json& node, const char* name) {
  const auto list = node.find(name);
  if (list == node.end() || !list->is_array()) return false;
  return std::all_of(list->begin(), list->end(), [](const nlohmann::json& file) {
    return file.is_object() && has_text(file, "path") && has_text(file, "content");
  });
}

bool is_node_report(const nlohmann::json& node) {
  if (!node.is_object()) return false;
  for (const char* name : {"name", "status", "key"})
    if (!has_text(node, name)) return false;
  const auto metrics = node.find("metrics"), error = node.find("error");
  if (metrics == node.end() || !metrics->is_object()) return false;
  const bool failed = error != node.end() && !error->is_null();
  if (failed && !(error->is_object() && has_text(*error, "code") && has_text(*error, "message")))
    return false;
  return has_files(node, "files") && has_files(node, "reads");
}

}  // namespace

nlohmann::json read_report(const std::filesystem::path& path) {
  nlohmann::json report = read_json_file(path);
  if (report.is_object()) check_report_format(report, path);
  if (!report.is_object() || (report.contains("sweep") && !has_text(report, "sweep"))) return nullptr;
  const auto nodes = report.find("nodes"), seconds = report.find("seconds");
  if (nodes == report.end() || !nodes->is_array() || seconds == report.end() || !seconds->is_number())
    return nullptr;
  if (!std::all_of(nodes->begin(), nodes->end(), is_node_report)) return nullptr;
  return report;
}

SweepTable::SweepTable(const SweepPoints& points) : points_(points), rows_(points.size()) {}

void SweepTable::add(std::size_t point, const nlohmann::json& report) {
  const PointSummary summary = summary_of(report);
  Row& row = rows_[point];
  row = {summary.status, summary.seconds, {}};
  for (const auto& node : report.at("nodes"))
    for (const auto& [name, v] : node.at("metrics").items()) {
      const auto [column, fresh] = columns_.try_emplace({node.at("name"), name}, columns_.size());
      if (v.is_number()) row.metrics.emplace_back(column->second, v.get<double>());
    }
  row.metrics.shrink_to_fit();
}

void SweepTable::write(const std::function<void(const std::string&)>& write) const {
  std::string line = "point";
  for (const auto& v : points_.vary()) line += "," + csv_cell(v.target);
  line += ",status,seconds";
  for (const auto& [metric, column] : columns_) line += "," + csv_cell(metric.first + "." + metric.second);
  write(line + "\n");
  std::vector<double> values(columns_.size());
  std::vector<bool> known(columns_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const SweepPoint point = points_[i];
    const Row& row = rows_[i];
    line = point.folder;
    for (const auto& [target, value] : point.values) line += "," + csv_cell(value);
    if (row.status.empty()) {
      write(line + ",not run," + std::string(columns_.size(), ',') + "\n");
      continue;
    }
    line += fmt::format(",{},{:.3f}", row.status, row.seconds);
    known.assign(columns_.size(), false);
    for (const auto& [column, value] : row.metrics) {
      values[column] = value;
      known[column] = true;
    }
    for (const auto& [metric, column] : columns_)
      line += known[column] ? fmt::format(",{}", values[column]) : ",";
    write(line + "\n");
  }
}

}  // namespace terrazzo
