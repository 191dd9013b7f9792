// The action key of a node: a hash of its type, version, canonical parameters, and the content of its files
// and inputs. Nothing else enters it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/cache/action_record.h"
#include "runtime/cache/file_hashes.h"

namespace terrazzo {

Hash action_key(const GraphNode&, const std::map<std::string, std::vector<Hash>>& files,
                const std::map<std::string, std::vector<OutputRecord>>& inputs);

// The key under which the computation is recorded. It equals `key`, except for nodes that write files: their
// files belong to one output folder, so each output folder has its own record.
Hash record_key(const NodeType&, const Hash& key, const std::filesystem::path& output_folder);

// The input files of a node by path parameter.
struct InputFiles {
  std::map<std::string, std::vector<std::filesystem::path>> paths;
  std::map<std::string, std::vector<Hash>> hashes;  // input_content() of each path
  std::vector<FileRecord> read;                     // every file, companions included, with its own content
};
// `memory`: the bytes that loading one file may take; 0: all available memory. A larger file is not read, not
// even for its hash, because every reader would refuse it. Throws Error "no-file", "unreadable-file" or
// "too-large", with the parameter.
InputFiles input_files(const GraphNode&, FileHashes&, std::uint64_t memory = 0);

// The files that a node of this type opens to read `path`: the file itself, then its companions.
std::vector<std::filesystem::path> files_opened(const NodeType&, const std::filesystem::path& path);

// A hash of everything that a node reads when it opens this file: the content, the extension (it selects the
// format), and the content of companion files. Nothing if the file cannot be read. Throws Error "too-large"
// if one of them has more than `most` bytes and its hash is not known.
std::optional<Hash> input_content(const NodeType&, const std::filesystem::path&, FileHashes&,
                                  std::uint64_t most);

}  // namespace terrazzo
