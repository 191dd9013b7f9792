// Runs one node type without a graph, with parameters written as in a graph file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/value.h"

namespace terrazzo::test {

struct NodeRun {
  std::map<std::string, Value> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  template <class T>
  const T& output(const std::string& name) const {
    return outputs.at(name).as<T>();
  }
};

// A list input gets several entries with the same port. Parameters are YAML: "3", "auto", "[1, 2]". Throws
// the node's Error, or an Error for an unknown port or a parameter that violates its declaration.
NodeRun run_node(const std::string& type, const std::multimap<std::string, Value>& inputs,
                 const std::map<std::string, std::string>& parameters = {},
                 const std::filesystem::path& output_folder = {}, int threads = 0);

// The shared data folder next to the checkout, or empty if there is none; tests that need it then skip.
std::filesystem::path shared_data();
// The folders of all nodes, sorted: those below nodes/ that contain an example.yaml.
std::vector<std::filesystem::path> node_folders();
// That of one type, such as nodes/shapes/shape_estimate of ShapeEstimate. Throws std::out_of_range if there
// is none.
std::filesystem::path node_folder(const std::string& type);
// A fresh folder that is removed when the test program ends.
std::filesystem::path temporary_folder();

}  // namespace terrazzo::test
