// One computation: a node type, its inputs and parameters, and what came of it. The only Context there is.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/context.h"
#include "runtime/value.h"

namespace terrazzo {

struct ComputeRequest {
  const NodeType* type = nullptr;
  std::map<std::string, std::vector<Value>> inputs;
  std::map<std::string, ParameterValue> parameters;  // all of them, defaults filled in
  std::map<std::string, std::vector<std::filesystem::path>> files;
  std::filesystem::path output_folder;
  std::vector<std::filesystem::path> protected_files;  // that the node must not overwrite: the graph's inputs
  std::string provenance;                              // JSON
  Work work;
  std::uint64_t memory = 0;  // bytes that loaders may take; 0: what the machine has left
};

struct ComputeResult {
  std::map<std::string, Value> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<std::string> files;  // relative to the output folder
};

// Throws Error (out of memory and foreign exceptions included) or Cancelled.
ComputeResult compute_node(ComputeRequest);

// Every parameter of the type: as written, else its default.
std::map<std::string, ParameterValue> effective_parameters(
    const NodeType&, const std::map<std::string, ParameterValue>& written);

}  // namespace terrazzo
