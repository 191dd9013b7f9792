// kill −9 at random moments of runs and of cache collections.
#include <csignal>
#include <stdexcept>

#include "runtime/random.h"
#include "tests/torture/bed.h"

namespace terrazzo::torture {

Counts kills(const Options& o) {
  Bed bed(o);
  Counts counts{{"kills", 0}, {"kills of collections", 0}, {"ended before", 0}, {"caches verified", 0}};
  const auto hold = [](const std::string& trouble) {
    if (!trouble.empty()) throw std::runtime_error(trouble);
  };
  double usual = bed.seconds();  // typical duration of a run, cached or not, on a machine however busy
  repeat(o, "kills", [&](std::uint64_t trial) {
    Random random(o.seed, 1, trial);
    if (trial % 20 == 0) bed.new_cache();
    if (trial % 15 == 0) bed.new_out();
    const int variant = static_cast<int>(random.below(Bed::variants));
    const bool collects = random.below(10) == 0, anew = random.below(30) == 0;
    ChildOptions options;
    if (anew) options.program = o.program;
    const auto arguments =
        collects
            ? std::vector<std::string>{"cache", "gc", "--cache", bed.cache().string(), "--cache-limit", "4K"}
            : bed.arguments(variant);
    const double after = (anew ? 0.3 : 0) + random.uniform(0, 1.1) * usual * (collects ? 0.5 : 1);
    const Ended e = run(arguments, bed.folder(), options, after);
    if (e.hung || (e.signal ? e.signal != SIGKILL : e.exit_code != 0)) throw std::runtime_error(e.text());
    ++counts[!e.signal ? "ended before" : collects ? "kills of collections" : "kills"];
    hold(bed.what_is_broken(bed.out()));
    hold(bed.what_the_user_lost());
    if (trial % 5 == 4) {
      const Ended verified =
          run({"cache", "verify", "--sample", "2", "--cache", bed.cache().string()}, bed.folder());
      if (verified.exit_code != 0) throw std::runtime_error("the cache is damaged: " + verified.text());
      ++counts["caches verified"];
    }
    const double begun = now();
    hold(bed.what_a_run_gives(random.below(2) ? variant : static_cast<int>(random.below(Bed::variants))));
    usual += 0.1 * (now() - begun - usual);
    hold(bed.what_the_user_lost());
  });
  return counts;
}

}  // namespace terrazzo::torture
