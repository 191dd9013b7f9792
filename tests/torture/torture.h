// What every part of the torture run shares.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
namespace terrazzo::torture {
struct Options {
  double seconds = 60;  // about how long this part may take
  std::uint64_t seed = 1;
  std::filesystem::path program;  // terrazzo
  std::filesystem::path source;   // the checkout, for graphs
  std::filesystem::path folder;   // empty, private to this part
};
using Counts = std::map<std::string, std::uint64_t>;  // "kills": 1000
// Each throws std::runtime_error that names seed and trial on the first loss, hang or stale value.
Counts mutated_inputs(const Options&);
Counts kills(const Options&);
Counts faults(const Options&);
Counts shared_cache(const Options&);
Counts flipped_bytes(const Options&);
Counts random_edits(const Options&);
}  // namespace terrazzo::torture
