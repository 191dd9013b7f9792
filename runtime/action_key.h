// The key of a node's computation: type, version, canonical parameters, content of files and inputs. Nothing
// else.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/action_record.h"
#include "runtime/file_hashes.h"

namespace terrazzo {

Hash action_key(const GraphNode&, const std::map<std::string, std::vector<Hash>>& files,
                const std::map<std::string, std::vector<OutputRecord>>& inputs);

// The key under which the computation is recorded. What a node writes lies in one output folder and says
// which run wrote it: each folder has its own record.
Hash record_key(const NodeType&, const Hash& key, const std::filesystem::path& output_folder);

// A path parameter's files and their content. Throws Error "no-file" with the parameter.
struct InputFiles {
  std::map<std::string, std::vector<std::filesystem::path>> paths;
  std::map<std::string, std::vector<Hash>> hashes;  // input_content
  std::vector<FileRecord> read;                     // every file, companions included, with its own content
};
InputFiles input_files(const GraphNode&, FileHashes&);

// The files that a node of this type opens for one that a parameter names: itself first, then its companions.
std::vector<std::filesystem::path> files_opened(const NodeType&, const std::filesystem::path&);

// What a node reads when it opens this file: content, extension (readers choose the format by it), and the
// content of companion files. Nothing if the file cannot be read.
std::optional<Hash> input_content(const NodeType&, const std::filesystem::path&, FileHashes&);

}  // namespace terrazzo
