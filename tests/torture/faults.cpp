// File operations that fail, return short counts or are interrupted, and full disks.
#include <fmt/format.h>
#include <sys/mount.h>

#include <cstring>
#include <stdexcept>

#include "runtime/random.h"
#include "tests/torture/bed.h"

namespace terrazzo::torture {
namespace fs = std::filesystem;
namespace {

void hold(const std::string& trouble) {
  if (!trouble.empty()) throw std::runtime_error(trouble);
}

// A file system of `kilobytes` in memory, mounted during this object's lifetime. Mounting may not be
// permitted.
class SmallDisk {
 public:
  SmallDisk(const fs::path& folder, std::uint64_t kilobytes) : folder_(folder) {
    fs::create_directories(folder);
    mounted_ = ::mount("none", folder.c_str(), "tmpfs", 0, fmt::format("size={}k", kilobytes).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }

 private:
  fs::path folder_;
  bool mounted_ = false;
};

// Checks that the process ended by itself and, if it failed, printed the reason.
void must_end_well(const Ended& e) {
  const bool clear = e.exit_code == 0 ||
                     ((e.exit_code == 1 || e.exit_code == 2) && e.err.find("error") != std::string::npos);
  if (e.hung || e.signal || !clear || e.err.find("uncaught") != std::string::npos ||
      e.err.find("node-bug") != std::string::npos)
    throw std::runtime_error(e.text());
}

FaultPlan plan_of(Random& random, const fs::path& folder) {
  FaultPlan plan;
  plan.seed = random.bits();
  static constexpr double rates[] = {0.01, 0.03, 0.1, 0.3, 1};
  plan.rate = rates[random.below(5)];
  plan.operations = static_cast<unsigned>(1 + random.below(all_operations));
  if (random.below(3))
    plan.operations &= ~static_cast<unsigned>(open_to_read);  // most of these would end a run immediately
  if (random.below(4) == 0) plan.full_after = 1 + random.below(300);
  if (random.below(2)) {
    plan.passing = true;
    plan.rate = 0.9;
    plan.operations = write_bytes;
    plan.full_after = 0;
  }
  std::strncpy(plan.folder, folder.c_str(), sizeof plan.folder - 1);
  return plan;
}

}  // namespace

Counts faults(const Options& o) {
  Bed bed(o);
  FaultCounts& injected = fault_counts();
  Counts counts{
      {"runs", 0}, {"runs that failed", 0}, {"faults", 0}, {"file size limits", 0}, {"full disks", 0}};
  repeat(o, "faults", [&](std::uint64_t trial) {
    Random random(o.seed, 2, trial);
    const int variant = static_cast<int>(random.below(Bed::variants));
    if (trial % 10 == 0) bed.new_cache();
    if (trial % 7 == 0) bed.new_out();
    ChildOptions options;
    const auto kind = random.below(20);
    fs::path out = bed.out(), cache = bed.cache();
    std::optional<SmallDisk> disk;
    if (kind == 0) {
      // The program's output goes to a file too, which must have room for the error message.
      options.largest_file = static_cast<std::int64_t>(300 + random.below(3000));
    } else if (kind == 1) {
      const fs::path full = bed.folder() / "full";
      disk.emplace(full, 4 + random.below(150));
      if (!disk->mounted()) return;
      (random.below(2) ? out : cache) =
          full;  // as deep as the other folders, because provenance contains relative paths
    } else {
      options.faults = plan_of(random, bed.folder());
      if (options.faults->passing) {  // a new cache requires more writes
        cache = bed.folder() / "passing_cache";
        fs::remove_all(cache);
      }
      if (random.below(50) == 0) options.program = o.program;
    }
    std::vector<std::string> arguments = bed.arguments(variant, out, cache);
    if (random.below(15) == 0 && !(options.faults && options.faults->passing))
      arguments = {"cache", "gc", "--cache", cache.string(), "--cache-limit", "4K"};
    const bool runs = arguments[0] == "run";
    if (disk && !runs) return;
    const Ended e = run(arguments, bed.folder(), options);
    must_end_well(e);
    if (runs && options.faults && options.faults->passing && e.exit_code != 0)
      throw std::runtime_error("short or interrupted writes must be retried: " + e.text());
    ++counts["runs"];
    counts["runs that failed"] += e.exit_code != 0;
    counts["file size limits"] += options.largest_file >= 0;
    counts["full disks"] += disk.has_value();
    counts["faults"] = injected.injected;
    hold(bed.what_is_broken(out));
    hold(bed.what_the_user_lost());
    if (runs && e.exit_code == 0) {
      const std::string differs = bed.what_differs(variant, out);
      if (!differs.empty()) throw std::runtime_error("the run succeeded, but " + differs + "; " + e.text());
    }
    hold(bed.what_a_run_gives(random.below(2) ? variant : static_cast<int>(random.below(Bed::variants))));
    hold(bed.what_the_user_lost());
  });
  return counts;
}

}  // namespace terrazzo::torture
