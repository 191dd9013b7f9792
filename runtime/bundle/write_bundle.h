// Writing bundles.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "graph/registry.h"

namespace terrazzo {

struct BundleRequest {
  std::filesystem::path graph;            // the graph's file
  std::optional<std::string> text = {};   // instead of the content of the file
  std::string license = {}, source = {};  // as the user states them
  std::filesystem::path preview = {};     // a picture; empty: none
};

// Writes the graph with its subgraphs, the files that its nodes read, licenses beside these, NOTES.md and
// bundle.json: as an archive if `to` ends in .zip, else as a folder that does not exist yet. Files keep their
// places relative to each other; what the graph names by an absolute path goes below files/, and the graph
// then names it there. What was written is read again and checked. Throws the first error of the graph, and
// Error "file-exists", "no-file", "cannot-bundle", "too-large", "overwrites-input" or "write-failed".
void write_bundle(const std::filesystem::path& to, const BundleRequest&, const Registry&);

}  // namespace terrazzo
