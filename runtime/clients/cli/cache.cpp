#include "runtime/cache/disk_cache.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "runtime/cache/cache_folder.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/report.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

struct CacheCommand : GraphOptions {
  std::uint64_t sample = 10, seed = 1;
};

void print_stats(const std::filesystem::path& folder, std::uint64_t limit) {
  const CacheStats s = cache_stats(folder);
  std::cout << fmt::format("{}\n{} used, limit {}\n{} values, {}; {} small values in records\n",
                           folder.string(), bytes_text(s.bytes()), bytes_text(limit), s.values.count,
                           bytes_text(s.values.bytes), s.in_records);
  for (const auto& [type, kind] : s.by_type)
    std::cout << fmt::format("  {:<18} {:>6} {:>10}\n", type, kind.count, bytes_text(kind.bytes));
  std::cout << fmt::format("{} records ({:.1f} s of computing time), {}\n{} other files, {}\n",
                           s.records.count, s.seconds, bytes_text(s.records.bytes), s.other.count,
                           bytes_text(s.other.bytes));
}

void print_collected(const Collected& c) {
  if (c.busy)
    std::cout << "nothing removed: another process is collecting now\n";
  else
    std::cout << fmt::format("removed {} values, {} records and {} leftover files ({}); {} remain\n",
                             c.values, c.records, c.leftovers, bytes_text(c.bytes), bytes_text(c.left));
}

int verify(const Program& program, const fs::path& folder, const CacheCommand& o) {
  const Work work(cancel_on_interrupt(), nullptr);
  const Verified v = verify_cache(folder, program.registry(), program.types(), o.sample, o.seed, work);
  for (const auto& f : v.damaged) std::cout << "removed a damaged entry: " << f << '\n';
  for (const auto& d : v.differing)
    std::cout << "removed a record whose result differs when recomputed: " << d << '\n';
  std::cout << fmt::format(
      "{} values and {} records read, {} damaged; {} recomputed, {} of them differ ({} skipped)\n", v.values,
      v.records, v.damaged.size(), v.recomputed, v.differing.size(), v.passed_over);
  if (v.lost > 0)
    std::cout << fmt::format("{} records have lost values, which are computed again when they are needed\n",
                             v.lost);
  return v.damaged.empty() && v.differing.empty() ? kDone : kNodeFailed;
}

}  // namespace

void add_cache(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("cache", "Inspect, verify or shrink the disk cache");
  command->require_subcommand(1);
  auto o = std::make_shared<CacheCommand>();
  const auto add = [&](const char* name, const char* help, std::function<void(const fs::path&)> act) {
    auto* sub = command->add_subcommand(name, help);
    add_cache_options(*sub, *o);
    sub->callback([o, act] {
      if (o->no_cache) throw Error("usage", "this command needs a cache: remove --no-cache");
      const fs::path folder = o->cache.empty() ? default_cache() : fs::path(o->cache);
      require_cache_folder(folder);
      act(folder);
    });
    return sub;
  };
  add("stats", "Print the number and size of the entries",
      [o](const fs::path& folder) { print_stats(folder, o->cache_limit); });
  auto* sub =
      add("verify",
          "Check every entry, recompute a random sample and compare; remove damaged or differing entries",
          [o, &program, &exit_code](const fs::path& folder) { exit_code = verify(program, folder, *o); });
  sub->add_option("--sample", o->sample, "Number of entries to recompute")
      ->type_name(placeholder::number)
      ->capture_default_str();
  sub->add_option("--seed", o->seed, "Random seed of the sample")
      ->type_name(placeholder::number)
      ->capture_default_str();
  add("gc", "Remove leftover files and, above --cache-limit, the least valuable entries",
      [o](const fs::path& folder) { print_collected(collect_cache(folder, o->cache_limit)); });
  add("clear", "Remove all entries", [](const fs::path& folder) { clear_cache(folder); });
}

}  // namespace terrazzo::cli
