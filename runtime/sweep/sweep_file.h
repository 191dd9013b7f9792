// sweep.json: everything that a worker on another machine needs to run points of a sweep.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/cache/file_hashes.h"
#include "runtime/cache/store.h"
#include "runtime/files/protected_files.h"
#include "runtime/sweep/sweep.h"

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

// What the sweep reads, which its own files must not replace.
ProtectedFiles protected_files(const SweepFile&);

// Throws Error "write-failed" or "overwrites-input".
void write_sweep_file(const std::filesystem::path&, const SweepFile&);
// Throws Error "sweep-file" if the file cannot be read or is not a sweep file of this format.
SweepFile read_sweep_file(const std::filesystem::path&);

// Throws Error "other-version" if this program or a node type differs from what the sweep was planned with.
void require_same_version(const SweepFile&, const Registry&);
// Throws Error "input-changed" if a file no longer has the content that it had when the sweep was planned.
void require_same_files(const SweepFile&, FileHashes&);

// Throws Error "input-changed" if the point of this report read a file with another content.
void require_same_reads(const SweepFile&, const nlohmann::json& report);

// Whether this report is the complete and successful result of a point of the sweep, and all files that it
// names still exist in `folder`, the point's folder.
bool is_finished_point(const nlohmann::json& report, const Hash& sweep, const std::filesystem::path& folder);

// Whether the cache still has what others need of the point with this report. Always true if values are
// varied, since the results of such points are their files and metrics.
bool is_in_cache(const SweepPoint&, const nlohmann::json& report, Store&);

// The report of what all points share. Null if it was not computed for this sweep. `out`: the sweep's folder.
nlohmann::json read_shared_report(const SweepFile&, const std::filesystem::path& out);
// Whether it was computed, and the cache still has all of it.
bool is_shared_in_cache(const SweepFile&, const nlohmann::json& shared_report, Store&);

}  // namespace terrazzo
