// The record of one computation: its results, and what is needed to repeat it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "graph/parameter.h"
#include "runtime/hash.h"

namespace terrazzo {

struct NodeType;  // graph/node_type.h

// Values of at most this many encoded bytes are stored in the records of the computations that made them.
// Such a record still fits into one block of most file systems.
inline constexpr std::size_t kSmallValue = 2048;

struct OutputRecord {
  std::string type;
  Hash content;  // hash of type name and encoded value
  std::uint64_t bytes = 0;
  // Type name and encoded value of a small value. Null for larger ones, which have files of their own.
  std::shared_ptr<const std::string> small = {};
  bool operator==(const OutputRecord& o) const {
    return type == o.type && content == o.content && bytes == o.bytes;
  }
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

  // Everything needed to repeat the computation without its graph.
  std::string type;
  int version = 0;
  std::map<std::string, ParameterValue> parameters;  // all parameters, defaults included
  std::map<std::string, std::vector<OutputRecord>> inputs;
  std::map<std::string, std::vector<FileRecord>> input_files;  // absolute paths; content: input_content()
};

// Whether the record has exactly the outputs of the node type, with values of the types that they declare.
// The record of a plugin that was changed under the same version may have others.
bool has_outputs_of(const ActionRecord&, const NodeType&);

// Reading throws nlohmann::json::exception or Error if the JSON is not a valid record.
nlohmann::json to_json(const ActionRecord&);
ActionRecord action_record_from_json(const nlohmann::json&);

}  // namespace terrazzo
