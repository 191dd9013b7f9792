// How a file was made: its provenance, and the graph that makes it again. Shared by `terrazzo reproduce` and
// the Python module.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/given.h"

namespace terrazzo::cli {

// The provenance of a file.
struct Made {
  std::string document;                                      // the graph that makes the file, as YAML
  std::map<std::string, std::string> keys;                   // action keys by node
  std::set<std::string> contents;                            // content hashes of the input files
  std::map<std::string, std::set<std::string>> contents_of;  // the same by node
  std::vector<std::filesystem::path> places;                 // where a report says that they were
  GivenValues values;  // arrays that Python gave; the registry needs register_given_types()
};

// Reads the provenance in the file, or in a report.json beside it. `read_provenance` reads that of a format;
// null if there is none. Throws Error "usage" if there is no provenance, if it is damaged, or if its graph
// refers to other graph files, which terrazzo never writes.
Made how_made(const std::filesystem::path& file, const ValueTypes&,
              std::string (*read_provenance)(const std::filesystem::path&));

// The graph. Searches the input files by name and content: in the file's folder and three above it, in
// `folders`, and where a report beside the file says that they were. Throws Error "given-array" if it needs
// an array that the provenance lacks.
Graph open_made(const Registry&, const Made&, const std::filesystem::path& file, const Overrides&,
                const std::vector<std::string>& folders, Diagnostics& found);

// A file that the graph would read. The provenance may come from a stranger, so a graph may read only files
// whose content it names, and those in folders that the user grants or that the user set.
struct MadeRead {
  std::filesystem::path file;
  bool granted;  // by the user
  bool named;    // the file it was made from
  bool allowed() const { return granted || named; }
};
std::vector<MadeRead> reads_of(const Graph&, const Made&, const std::vector<std::string>& granted_folders);

}  // namespace terrazzo::cli
