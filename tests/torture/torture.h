// Shared by all parts of the torture run.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
namespace terrazzo::torture {
struct Options {
  double seconds = 60;  // approximate duration of this part
  std::uint64_t seed = 1;
  std::filesystem::path program;  // terrazzo
  std::filesystem::path source;   // the checkout, which contains the graphs
  std::filesystem::path folder;   // empty folder, private to this part
};
using Counts = std::map<std::string, std::uint64_t>;  // such as "kills": 1000
// Each part throws std::runtime_error with seed and trial on the first loss, hang or stale value.
Counts mutated_inputs(const Options&);
Counts kills(const Options&);
Counts faults(const Options&);
Counts shared_cache(const Options&);
Counts flipped_bytes(const Options&);
Counts random_edits(const Options&);
}  // namespace terrazzo::torture
