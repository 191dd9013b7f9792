#include "runtime/disk_cache.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "runtime/cache_folder.h"
#include "runtime/cli/commands.h"
#include "runtime/cli/report.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct CacheCommand : GraphOptions {
  std::uint64_t sample = 10, seed = 1;
};

void print_stats(const std::filesystem::path& folder, std::uint64_t limit) {
  const CacheStats s = cache_stats(folder);
  std::cout << fmt::format("{}\n{} of at most {}\n{} values, {}\n", folder.string(), bytes_text(s.bytes()),
                           bytes_text(limit), s.values.count, bytes_text(s.values.bytes));
  for (const auto& [type, kind] : s.by_type)
    std::cout << fmt::format("  {:<18} {:>6} {:>10}\n", type, kind.count, bytes_text(kind.bytes));
  std::cout << fmt::format("{} computations of {:.1f} s in all, {}\n{} other files, {}\n", s.records.count,
                           s.seconds, bytes_text(s.records.bytes), s.other.count, bytes_text(s.other.bytes));
}

void print_collected(const Collected& c) {
  if (c.busy)
    std::cout << "another process is collecting\n";
  else
    std::cout << fmt::format("removed {} values, {} records and {} leftovers, {}; {} remain\n", c.values,
                             c.records, c.leftovers, bytes_text(c.bytes), bytes_text(c.left));
}

int verify(const Program& program, const fs::path& folder, const CacheCommand& o) {
  const Work work(cancel_on_interrupt(), nullptr);
  const Verified v = verify_cache(folder, program.registry(), program.types(), o.sample, o.seed, work);
  for (const auto& f : v.damaged) std::cout << "damaged, removed: " << f << '\n';
  for (const auto& d : v.differing) std::cout << "computed again it differs, forgotten: " << d << '\n';
  std::cout << fmt::format(
      "{} values and {} records read, {} damaged; {} computed again, {} of them differ ({} passed over)\n",
      v.values, v.records, v.damaged.size(), v.recomputed, v.differing.size(), v.passed_over);
  return v.damaged.empty() && v.differing.empty() ? done : node_failed;
}

}  // namespace

void add_cache(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("cache", "The disk cache: what is in it, is it sound, make room");
  command->require_subcommand(1);
  auto o = std::make_shared<CacheCommand>();
  const auto add = [&](const char* name, const char* help, std::function<void(const fs::path&)> act) {
    auto* sub = command->add_subcommand(name, help);
    add_cache_options(*sub, *o);
    sub->callback([o, act, &exit_code] {
      if (o->no_cache) throw Error("usage", "--no-cache leaves no cache to look at");
      const fs::path folder = o->cache.empty() ? default_cache() : fs::path(o->cache);
      if (!is_cache_folder(folder))
        throw Error("usage", "'" + folder.string() + "' is not a cache folder of this version",
                    "a folder becomes one when a run uses it with --cache");
      act(folder);
    });
    return sub;
  };
  add("stats", "How much is in it", [o](const fs::path& folder) { print_stats(folder, o->cache_limit); });
  auto* sub =
      add("verify", "Read every entry, compute a sample again and compare; remove what does not hold",
          [o, &program, &exit_code](const fs::path& folder) { exit_code = verify(program, folder, *o); });
  sub->add_option("--sample", o->sample, "How many to compute again")->capture_default_str();
  sub->add_option("--seed", o->seed, "Chooses the sample")->capture_default_str();
  add("gc", "Remove leftovers and, beyond --cache-limit, the least valuable entries",
      [o](const fs::path& folder) { print_collected(collect_cache(folder, o->cache_limit)); });
  add("clear", "Remove every entry", [](const fs::path& folder) { clear_cache(folder); });
}

}  // namespace terrazzo::cli
