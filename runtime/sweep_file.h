// sweep.json: everything that a worker on another machine needs to run points of a sweep.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/file_hashes.h"
#include "runtime/sweep.h"

namespace terrazzo {

struct SweepFile {
  std::string folder;                // working folder: relative paths in settings start here
  std::string graph;                 // absolute path
  std::vector<std::string> targets;  // as in RunOptions, by name; empty: the graph's sinks
  SweepPoints points;
  std::string program;                       // program_version
  std::map<std::string, int> versions;       // of the node types in the graph
  std::map<std::string, std::string> files;  // graph files and input files: absolute path → content hash
  std::vector<std::string> shared;           // nodes to compute once before the points; may be empty

  // Identifies the sweep: two sweeps with equal hashes have equal points, inputs and versions.
  Hash hash() const;
};

// Throws Error "write-failed".
void write_sweep_file(const std::filesystem::path&, const SweepFile&);
// Throws Error "sweep-file" if the file cannot be read or is not a sweep file of this format.
SweepFile read_sweep_file(const std::filesystem::path&);

// Throws Error "other-version" if this program or a node type differs from what the sweep was planned with.
void require_same_version(const SweepFile&, const Registry&);
// Throws Error "input-changed" if a file no longer has the content that it had when the sweep was planned.
void require_same_files(const SweepFile&, FileHashes&);

// Throws the same if the point of this report read a file with another content.
void require_same_reads(const SweepFile&, const nlohmann::json& report);

// Whether this report is the complete and successful result of a point of the sweep, and all files that it
// names still exist in `folder`, the point's folder.
bool is_finished_point(const nlohmann::json& report, const Hash& sweep, const std::filesystem::path& folder);

}  // namespace terrazzo
