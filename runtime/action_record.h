// What is known of one computation: its results, and how to do it again.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "graph/parameter.h"
#include "runtime/hash.h"

namespace terrazzo {

struct OutputRecord {
  std::string type;
  Hash content;  // of type and encoded value
  std::uint64_t bytes = 0;
  bool operator==(const OutputRecord&) const = default;
};

struct FileRecord {
  std::string path;  // relative to the output folder
  Hash content;
  bool operator==(const FileRecord&) const = default;
};

struct ActionRecord {
  std::map<std::string, OutputRecord> outputs;  // by port
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;
  std::vector<FileRecord> files;
  double seconds = 0;

  // What it was computed from: enough to compute it again without its graph.
  std::string type;
  int version = 0;
  std::map<std::string, ParameterValue> parameters;  // all of them
  std::map<std::string, std::vector<OutputRecord>> inputs;
  std::map<std::string, std::vector<FileRecord>> input_files;  // absolute paths; content with extension
};

// Throws nlohmann::json::exception or Error where the JSON is none of ours.
nlohmann::json to_json(const ActionRecord&);
ActionRecord action_record_from_json(const nlohmann::json&);

}  // namespace terrazzo
