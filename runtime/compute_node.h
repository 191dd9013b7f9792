// Runs one computation: a node type with its inputs and parameters. Implements Context.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/context.h"
#include "runtime/value.h"

namespace terrazzo {

class ProtectedFiles;  // runtime/files/protected_files.h

// What a canceled computation wants to save: the arguments of Context::save_interrupted.
struct InterruptedWork {
  std::string extension, what, hint;
  std::function<void(const std::filesystem::path& temporary)> write;
};

struct ComputeRequest {
  const NodeType* type = nullptr;
  std::map<std::string, std::vector<Value>> inputs;
  // Inputs with one_at_a_time(), unless they are in `inputs`.
  std::map<std::string, std::vector<std::function<Value()>>> later;
  std::map<std::string, ParameterValue> parameters;  // all parameters, defaults included
  std::map<std::string, std::vector<std::filesystem::path>> files;
  std::filesystem::path output_folder;
  std::shared_ptr<const ProtectedFiles> keep;  // must not be overwritten; null: there are none
  // Called before a file is written, with its path and its name in messages. Throws Error "same-file" if
  // another node of the run has written it. May be null.
  std::function<void(const std::filesystem::path&, const std::string& shown)> claim;
  std::string provenance;  // JSON
  Work work;
  std::function<void(const InterruptedWork&)> save_interrupted;  // null: nothing is saved
  std::uint64_t memory = 0;       // bytes that loaders may allocate; 0: all available memory
  std::function<bool()> watched;  // null: never
  std::function<void(const std::string& port, Value)> preview;  // set if `watched` is
  Intermediates intermediates;
};

struct ComputeResult {
  std::map<std::string, Value> outputs;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<std::string> files;  // relative to the output folder
};

// Throws Error or Cancelled. Other exceptions, such as std::bad_alloc, are converted to Error.
ComputeResult compute_node(ComputeRequest);

// Every parameter of the type: its written value, otherwise its default. Throws Error "missing-parameter".
std::map<std::string, ParameterValue> effective_parameters(
    const NodeType&, const std::map<std::string, ParameterValue>& written);

}  // namespace terrazzo
