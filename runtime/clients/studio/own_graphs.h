// Graph files and bundles of the user, below the folder in which the Studio was started.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/registry.h"
#include "runtime/clients/studio/workspace.h"

namespace terrazzo::studio {

struct OwnGraph {
  std::string file;  // relative to the folder
  double changed;    // seconds since 1970
};

struct OwnBundle {
  std::string file;  // relative to the folder
  std::string title, doc;
  bool picture;
};

// What the user has below the folder.
struct OwnFiles {
  std::vector<OwnGraph> graphs;
  std::vector<OwnBundle> bundles;
};

// The graph files and bundles that changed last, newest first: at most 60, and at most four folders deep.
// Looks at 20,000 files at most, and not into hidden folders.
OwnFiles own_files(const Workspace&);

// The graph of a bundle, to work on: in its folder, or, of an archive, in the folder of its name in `folder`,
// into which it is extracted unless that has happened before. Throws what check_bundle() and extract_bundle()
// throw.
std::filesystem::path graph_of_bundle(const std::filesystem::path& bundle,
                                      const std::filesystem::path& folder, const Registry&);

}  // namespace terrazzo::studio
