// Finished evaluations, so that earlier states can be shown again: their values are in the cache.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "runtime/clients/studio/live/node_states.h"

namespace terrazzo::studio {

class PastStates {
 public:
  // Of the graph, and of the files of subgraphs that were opened.
  struct Texts {
    std::string graph;
    std::map<std::filesystem::path, std::string> inside;

    bool operator==(const Texts&) const = default;
    std::size_t bytes() const;
    std::string joined() const;
  };
  struct State {
    std::size_t number;
    Texts texts;
    std::string changed;  // what is new in its first lines that the state before has not
    std::chrono::system_clock::time_point when;
    std::map<std::string, NodeResult> nodes;
  };

  // Adds the state after an evaluation; replaces the last one if the texts are the same.
  void add(Texts, const NodeStates&);
  // A file of a subgraph, which no state has changed so far.
  void add_file(const std::filesystem::path&, const std::string& text);
  void clear();
  // [{number, changed, when: seconds since 1970, output}], oldest first. `output`: {type, hash, bytes} of the
  // node's port, if the state has it.
  nlohmann::json list(const std::string& node = {}, const std::string& port = {}) const;
  // Throws Error "unknown-state".
  const State& at(std::size_t number) const;

 private:
  std::deque<State> states_;  // the most recent ones
  std::size_t made_ = 0, bytes_ = 0;
};

// {number, nodes: {path: {outputs, metrics}}}.
nlohmann::json json_of(const PastStates::State&);

}  // namespace terrazzo::studio
