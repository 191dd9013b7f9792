// Flips bytes and truncates files in the cache and in the output folder between runs.
#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/torture/bed.h"

namespace terrazzo::torture {
namespace fs = std::filesystem;
namespace {

// Files that the program wrote to the folder, in a fixed order.
std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const auto& e : fs::recursive_directory_iterator(folder))
    if (e.is_regular_file() && e.file_size() > 0 && e.path().extension() != ".doc" &&
        e.path().extension() != ".txt")
      found.push_back(e.path());
  std::sort(found.begin(), found.end());
  return found;
}

void damage(const fs::path& file, Random& random) {
  std::string text = read_file(file).value_or("");
  switch (random.below(8)) {
    case 0:
      text.resize(random.below(text.size()));
      break;
    case 1:
      text += text.substr(random.below(text.size()));
      break;
    case 2:
      std::fill(text.begin() + static_cast<std::ptrdiff_t>(random.below(text.size())), text.end(), '\0');
      break;
    default:
      for (auto flips = 1 + random.below(4); flips > 0; --flips)
        text[random.below(text.size())] ^= static_cast<char>(1 << random.below(8));
  }
  std::ofstream(file, std::ios::binary) << text;
}

}  // namespace

Counts flipped_bytes(const Options& o) {
  Bed bed(o);
  Counts counts{{"files damaged", 0}, {"caches refused", 0}};
  repeat(o, "flipped_bytes", [&](std::uint64_t trial) {
    Random random(o.seed, 4, trial);
    if (trial == 0) bed.new_cache();
    const int variant = static_cast<int>(random.below(Bed::variants));
    std::string what;
    for (auto n = 1 + random.below(3); n > 0; --n) {
      const auto files = files_below(random.below(5) ? bed.cache() : bed.out());
      if (files.empty()) continue;
      const fs::path& file = files[random.below(files.size())];
      damage(file, random);
      what += " " + file.string();
      ++counts["files damaged"];
    }
    const Ended e = run(bed.arguments(variant), bed.folder());
    if (e.hung || e.signal) throw std::runtime_error(e.text() + "; damaged:" + what);
    if (e.exit_code != 0) {
      // A cache folder whose marker is damaged may be refused, if the message says so.
      if (e.err.find("cache") == std::string::npos) throw std::runtime_error(e.text() + "; damaged:" + what);
      ++counts["caches refused"];
      bed.new_cache();
    } else if (const std::string differs = bed.what_differs(variant, bed.out()); !differs.empty()) {
      throw std::runtime_error(differs + "; damaged:" + what);
    }
    if (const std::string lost = bed.what_the_user_lost(); !lost.empty()) throw std::runtime_error(lost);
  });
  return counts;
}

}  // namespace terrazzo::torture
