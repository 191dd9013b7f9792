// ./dev torture [SECONDS [SEED [PART…]]]: runs every part for about SECONDS and prints its counts. The exit
// code is 1 if a part lost data.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "tests/torture/torture.h"

using namespace terrazzo::torture;
namespace fs = std::filesystem;

namespace {

struct Part {
  const char* name;
  Counts (*run)(const Options&);
};

const Part parts[] = {
    {"kills", kills},
    {"faults", faults},
    {"shared_cache", shared_cache},
    {"flipped_bytes", flipped_bytes},
    {"random_edits", random_edits},
#ifdef TERRAZZO_TORTURE_READERS
    {"mutated_inputs", mutated_inputs},
#endif
};

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  if (argc > 1) o.seconds = std::stod(argv[1]);
  if (argc > 2) o.seed = std::stoull(argv[2]);
  const std::vector<std::string> chosen(argv + std::min(argc, 3), argv + argc);
  for (const auto& name : chosen)
    if (std::none_of(std::begin(parts), std::end(parts), [&](const Part& p) { return name == p.name; }))
      throw std::runtime_error("there is no part '" + name + "'");
  o.program = TERRAZZO_PROGRAM;
  o.source = TERRAZZO_SOURCE;
  int lost = 0;
  for (const Part& part : parts) {
    if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), part.name) == chosen.end()) continue;
    std::string folder = (fs::temp_directory_path() / "terrazzo-torture-XXXXXX").string();
    if (!::mkdtemp(folder.data())) throw std::runtime_error("cannot make a temporary folder");
    o.folder = folder;
    std::printf("%s (seed %llu)", part.name, static_cast<unsigned long long>(o.seed));
    std::fflush(stdout);
    try {
      for (const auto& [what, number] : part.run(o))
        std::printf("\n  %10llu %s", static_cast<unsigned long long>(number), what.c_str());
      std::printf("\n");
      fs::remove_all(folder);
    } catch (const std::exception& e) {
      ++lost;
      std::printf("\n  LOST: %s\n  its files are in %s\n", e.what(), folder.c_str());
    }
    std::fflush(stdout);
  }
  return lost ? 1 : 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "error: %s\n", e.what());
  return 2;
}
