#include "runtime/sweep.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "graph/utf8.h"

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

bool number(const std::string& s, double& out) {
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), out);
  return error == std::errc() && end == s.data() + s.size() && std::isfinite(out);
}

std::string csv_cell(const std::string& s) {
  if (s.find_first_of(",\"\n") == std::string::npos) return s;
  std::string out = "\"";
  for (const char c : s) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace

Vary parse_vary(const std::string& text) {
  if (find_invalid_utf8(text) != std::string::npos) bad(valid_utf8(text), "is not UTF-8");
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) bad(text, "has no values");
  Vary out{text.substr(0, equals), {}};
  const std::string values = text.substr(equals + 1);
  const auto range = split(values, ':');
  double lo, hi, step;
  if (range.size() == 3 && number(range[0], lo) && number(range[1], hi) && number(range[2], step)) {
    if (step == 0 || (hi - lo) / step < 0) bad(text, "the step must be nonzero and lead from LO to HI");
    const double steps = std::floor((hi - lo) / step + 1e-9);
    if (steps >= 100000) bad(text, "has more than 100,000 values");
    // Rounds to 12 digits, so that 0.1 + 2 × 0.1 is 0.3 and not 0.30000000000000004.
    for (double k = 0; k <= steps; ++k) out.values.push_back(fmt::format("{:.12g}", lo + k * step));
    return out;
  }
  for (auto& v : split(values, ',')) {
    if (v.empty()) bad(text, "has an empty value");
    out.values.push_back(std::move(v));
  }
  return out;
}

std::vector<SweepPoint> sweep_points(const std::vector<Vary>& vary, const Overrides& common) {
  std::set<std::string> targets;
  std::size_t n = 1;
  for (const auto& v : vary) {
    if (!targets.insert(v.target).second) throw Error("usage", "'" + v.target + "' is varied twice");
    n *= v.values.size();
    if (n > 100000) throw Error("usage", "the sweep has more than 100,000 points");
  }
  const std::size_t width = std::max<std::size_t>(3, std::to_string(n).size());
  std::vector<SweepPoint> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    SweepPoint& p = out[i];
    p.index = i + 1;
    p.folder = fmt::format("point-{:0{}}", i + 1, width);
    p.overrides = common;
    std::size_t rest = i;
    p.values.resize(vary.size());
    for (std::size_t k = vary.size(); k-- > 0;) {
      p.values[k] = {vary[k].target, vary[k].values[rest % vary[k].values.size()]};
      rest /= vary[k].values.size();
    }
    for (const auto& value : p.values)
      (value.first.find('.') == std::string::npos ? p.overrides.parameters : p.overrides.set)
          .push_back(value);
  }
  return out;
}

std::string sweep_table(const std::vector<SweepPoint>& points, const std::vector<nlohmann::json>& reports) {
  std::set<std::pair<std::string, std::string>> metrics;
  for (const auto& report : reports)
    if (report.is_object())
      for (const auto& node : report.at("nodes"))
        for (const auto& [name, v] : node.at("metrics").items()) metrics.insert({node.at("name"), name});
  std::string out = "point";
  if (!points.empty())
    for (const auto& [target, value] : points[0].values) out += "," + csv_cell(target);
  out += ",status,seconds";
  for (const auto& [node, name] : metrics) out += "," + csv_cell(node + "." + name);
  out += "\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    out += points[i].folder;
    for (const auto& [target, value] : points[i].values) out += "," + csv_cell(value);
    if (!reports[i].is_object()) {
      out += ",not run," + std::string(metrics.size(), ',') + "\n";
      continue;
    }
    std::string status = "done";
    std::map<std::pair<std::string, std::string>, double> values;
    for (const auto& node : reports[i].at("nodes")) {
      if (node.at("status") == "failed" || node.at("status") == "cancelled") status = node.at("status");
      for (const auto& [name, v] : node.at("metrics").items())
        if (v.is_number()) values[{node.at("name"), name}] = v.get<double>();
    }
    out += fmt::format(",{},{:.3f}", status, reports[i].at("seconds").get<double>());
    for (const auto& m : metrics) {
      const auto it = values.find(m);
      out += it == values.end() ? "," : fmt::format(",{}", it->second);
    }
    out += "\n";
  }
  return out;
}

}  // namespace terrazzo
