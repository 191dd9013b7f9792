// Bundles: a material with all that it reads, as a folder or as a .zip. Its file bundle.json names the graph.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "graph/registry.h"

namespace terrazzo {

inline constexpr const char* kBundleManifest = "bundle.json";
inline constexpr int kBundleFormat = 1;

// What bundle.json says, as far as others need it.
struct BundleInfo {
  std::string graph;  // its name in the bundle
  std::string title, doc;
  std::string license, source;  // as its author states them; "" if not
  std::string preview;          // name of a picture; "" if there is none
  std::string version;          // of the program that wrote it
};

// A folder with a bundle.json, or a zip archive.
bool is_bundle(const std::filesystem::path&);

// Throws Error "bad-bundle".
BundleInfo read_bundle_info(const std::filesystem::path& bundle);
// The picture, if there is one of at most 64 MiB. Throws Error "bad-bundle".
std::optional<std::string> read_bundle_preview(const std::filesystem::path& bundle);

// Makes sure that the graph of a bundle's folder has no errors and that it and its subgraphs refer only to
// files in this folder, with links resolved. Returns the graph's file. Throws Error "bad-bundle",
// "outside-bundle", or the graph's first error.
std::filesystem::path check_bundle(const std::filesystem::path& folder, const Registry&);

// check_bundle(), for an archive after extract_bundle() into a temporary folder that is removed when the
// process ends.
std::filesystem::path open_bundle(const std::filesystem::path& bundle, const Registry&);

// The same, but an archive is extracted below `folder`, in a folder named after its content, where it stays
// and other processes find it.
std::filesystem::path keep_bundle(const std::filesystem::path& bundle, const std::filesystem::path& folder,
                                  const Registry&);

// Extracts an archive into a folder that does not exist yet, and checks it before it gets its name. Throws
// what extract_zip() and check_bundle() throw, and Error "file-exists".
void extract_bundle(const std::filesystem::path& zip, const std::filesystem::path& folder, const Registry&);

}  // namespace terrazzo
