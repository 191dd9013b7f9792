// Zip archives of bundles. Archives come from strangers: see docs/security.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terrazzo {

// What an archive may hold.
inline constexpr std::uint64_t kMostBundleBytes = std::uint64_t{16} << 30;
inline constexpr std::size_t kMostBundleFiles = 10'000;

// A file by its name in the bundle: "photos/a.jpg".
struct BundleFile {
  std::string name;
  std::filesystem::path from;  // where its content is; empty: `text` is
  std::string text;
};

// Why a file of a bundle cannot have this name: it could lead out of the folder, or be read differently
// elsewhere. "" if it can.
std::string trouble_with_name(const std::string&);

bool is_zip_file(const std::filesystem::path&);

// Equal files give equal bytes. Throws Error "write-failed".
void write_zip(const std::filesystem::path& to, const std::vector<BundleFile>&);

// Extracts all files into an empty folder. Refuses archives with absolute names, "..", links, encrypted
// files, names that differ only in case, and more than the limits above, before it writes anything. Throws
// Error "bad-bundle", "too-large" or "write-failed".
void extract_zip(const std::filesystem::path& zip, const std::filesystem::path& folder);

// One file of an archive, if it is there and has at most `most` bytes. Throws Error "bad-bundle".
std::optional<std::string> read_from_zip(const std::filesystem::path& zip, const std::string& name,
                                         std::uint64_t most);

}  // namespace terrazzo
