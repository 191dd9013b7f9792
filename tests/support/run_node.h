// Runs one node type without a graph, with parameters as they would be written in a graph file.
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

// A wire list for an input that takes many is given as several entries. Parameters are YAML: "3", "auto",
// "[1, 2]". Throws what the node throws (Error), and Error for an unknown port or a parameter outside its
// declaration.
NodeRun run_node(const std::string& type, const std::multimap<std::string, Value>& inputs,
                 const std::map<std::string, std::string>& parameters = {},
                 const std::filesystem::path& output_folder = {}, int threads = 0);

// The shared data folder beside the checkout, or empty where it is absent: tests that need it then skip.
std::filesystem::path shared_data();
// A fresh folder that is removed when the test program ends.
std::filesystem::path temporary_folder();

}  // namespace terrazzo::test
