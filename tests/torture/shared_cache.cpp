// Four processes share one cache while a fifth collects it.
#include <fmt/format.h>

#include <stdexcept>

#include "runtime/random.h"
#include "tests/torture/bed.h"

namespace terrazzo::torture {

Counts shared_cache(const Options& o) {
  Bed bed(o);
  Counts counts{{"runs", 0}, {"collections", 0}};
  repeat(o, "shared_cache", [&](std::uint64_t trial) {
    Random random(o.seed, 3, trial);
    if (trial % 50 == 0) bed.new_cache();
    std::vector<Child> running;
    std::vector<int> variants;
    for (int i = 0; i < 4; ++i) {
      variants.push_back(static_cast<int>(random.below(Bed::variants)));
      running.emplace_back(
          bed.arguments(variants.back(), bed.folder() / fmt::format("out{}", i), bed.cache()), bed.folder());
    }
    for (int i = 0; i < 3; ++i) {
      const Ended e = run({"cache", "gc", "--cache", bed.cache().string(), "--cache-limit",
                           std::to_string(random.below(20000))},
                          bed.folder());
      if (e.exit_code != 0) throw std::runtime_error("collecting the cache failed: " + e.text());
      ++counts["collections"];
    }
    for (std::size_t i = 0; i < running.size(); ++i) {
      const Ended e = running[i].wait();
      if (e.exit_code != 0) throw std::runtime_error("a run failed: " + e.text());
      const std::string differs = bed.what_differs(variants[i], bed.folder() / fmt::format("out{}", i));
      if (!differs.empty()) throw std::runtime_error(differs + "; " + e.text());
      ++counts["runs"];
    }
    if (const std::string lost = bed.what_the_user_lost(); !lost.empty()) throw std::runtime_error(lost);
  });
  return counts;
}

}  // namespace terrazzo::torture
