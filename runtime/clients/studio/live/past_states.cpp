#include "runtime/clients/studio/live/past_states.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "graph/diagnostic.h"

namespace terrazzo::studio {
using nlohmann::json;
namespace {

constexpr std::size_t kMostStates = 200, kMostPastBytes = 32 << 20;

// A line, or of an entry on one line, "a: {type: T, params: {x: 1}}", what differs from the line before: "a:
// x: 1".
std::string difference(const std::string& line, const std::vector<std::string>& gone) {
  const auto colon = line.find(':');
  const auto same = std::ranges::find_if(gone, [&](const auto& old) {
    return colon != std::string::npos && old.starts_with(line.substr(0, colon + 1));
  });
  if (same == gone.end()) return line.substr(0, 100);
  const auto [now, old] = std::ranges::mismatch(line, *same);
  const auto from = line.find_last_of("{,", static_cast<std::size_t>(now - line.begin()));
  if (now == line.end() || from == std::string::npos || from < colon) return line.substr(0, 100);
  const auto start = line.find_first_not_of(' ', from + 1), end = line.find_first_of(",}", start);
  return line.substr(0, colon + 2) + line.substr(start, std::min<std::size_t>(end - start, 80));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (const auto start = line.find_first_not_of(' '); start != std::string::npos)
      out.push_back(line.substr(start));
  return out;
}

// The first lines that are new.
std::string changes(const std::string& before, const std::string& now) {
  const std::vector<std::string> old = lines_of(before), fresh = lines_of(now);
  const std::set<std::string> known(old.begin(), old.end()), kept(fresh.begin(), fresh.end());
  std::vector<std::string> gone;
  std::ranges::copy_if(old, std::back_inserter(gone), [&](const auto& line) { return !kept.count(line); });
  std::string out;
  int count = 0;
  for (const auto& line : fresh)
    if (!known.count(line) && ++count <= 3) out += (count > 1 ? "; " : "") + difference(line, gone);
  return count > 3 ? out + " …" : out;
}

}  // namespace

std::string PastStates::Texts::joined() const {
  std::string out = graph;
  for (const auto& [file, text] : inside) out += "\n" + text;
  return out;
}

std::size_t PastStates::Texts::bytes() const {
  std::size_t out = graph.size();
  for (const auto& [file, text] : inside) out += text.size();
  return out;
}

void PastStates::add_file(const std::filesystem::path& file, const std::string& text) {
  for (State& s : states_)
    if (s.texts.inside.try_emplace(file, text).second) bytes_ += text.size();
}

void PastStates::add(Texts texts, const NodeStates& nodes) {
  State s{.number = made_ + 1,
          .texts = std::move(texts),
          .changed = {},
          .when = std::chrono::system_clock::now(),
          .nodes = {}};
  for (const auto& [path, n] : nodes)
    if (n.state == "cached" || n.state == "computed") s.nodes[path] = n.result;
  if (!states_.empty() && states_.back().texts == s.texts) {
    s.number = states_.back().number;
    s.changed = states_.back().changed;
    states_.back() = std::move(s);
    return;
  }
  ++made_;
  if (!states_.empty()) s.changed = changes(states_.back().texts.joined(), s.texts.joined());
  bytes_ += s.texts.bytes();
  states_.push_back(std::move(s));
  while (states_.size() > 1 && (states_.size() > kMostStates || bytes_ > kMostPastBytes)) {
    bytes_ -= states_.front().texts.bytes();
    states_.pop_front();
  }
}

void PastStates::clear() {
  states_.clear();
  bytes_ = 0;
}

json PastStates::list(const std::string& node, const std::string& port) const {
  json out = json::array();
  for (const auto& s : states_) {
    out.push_back({{"number", s.number},
                   {"changed", s.changed},
                   {"when", std::chrono::duration<double>(s.when.time_since_epoch()).count()}});
    if (const auto result = s.nodes.find(node); result != s.nodes.end())
      if (const auto o = result->second.outputs.find(port); o != result->second.outputs.end())
        out.back()["output"] = json_of(o->second);
  }
  return out;
}

const PastStates::State& PastStates::at(std::size_t number) const {
  const auto it = std::ranges::find(states_, number, &State::number);
  if (it == states_.end()) throw Error("unknown-state", "this state of the graph is no longer kept");
  return *it;
}

json json_of(const PastStates::State& s) {
  json nodes = json::object();
  for (const auto& [path, r] : s.nodes) {
    json outputs = json::object();
    for (const auto& [port, o] : r.outputs) outputs[port] = json_of(o);
    nodes[path] = {{"outputs", outputs}, {"metrics", r.metrics}};
  }
  return {{"number", s.number}, {"nodes", nodes}};
}

}  // namespace terrazzo::studio
