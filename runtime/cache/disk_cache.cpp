#include "runtime/cache/disk_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "runtime/cache/action_key.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/cache/store.h"
#include "runtime/cache/value_file.h"
#include "runtime/compute_node.h"
#include "runtime/files.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

bool removed(const fs::path& path) {
  std::error_code error;
  return fs::remove(path, error);
}

constexpr double kHour = 3600, kDay = 24 * kHour;

std::shared_ptr<const ActionRecord> record_in(const CacheFile& f) {
  const auto text = f.name ? read_file(f.path) : std::nullopt;
  return text ? parse_action(*text) : nullptr;
}

bool any_value_of(const fs::path& folder, const ActionRecord& record) {
  std::error_code error;
  for (const auto& [port, o] : record.outputs)
    if (o.small || fs::exists(cache_entry(folder, "values", o.content), error)) return true;
  return false;
}

// Removes a file that saves no time: a leftover of an interrupted writer, or an entry other than a value that
// is unused for 90 days and, if it is a record, has lost its values. True if the file was removed.
bool remove_worthless(const fs::path& folder, const char* table, const CacheFile& f, Collected& out) {
  if (f.age <= (f.name ? 90 * kDay : kHour)) return false;  // younger temporary files may still be in use
  const std::string name = table;
  if (f.name && name == "values") return false;
  const bool is_record = f.name && name == "actions";
  if (is_record)
    if (const auto record = record_in(f); record && any_value_of(folder, *record)) return false;
  if (!removed(f.path)) return false;
  ++(is_record ? out.records : out.leftovers);
  out.bytes += f.bytes;
  return true;
}

}  // namespace

CacheStats cache_stats(const fs::path& folder) {
  CacheStats out;
  const auto add = [](CacheStats::Kind& k, const CacheFile& f) {
    ++k.count;
    k.bytes += f.bytes;
  };
  for (const char* table : kCacheTables)
    each_cache_file(folder, table, -1, [&](const CacheFile& f) {
      const std::string name = table;
      if (f.name && name == "actions") {
        add(out.records, f);
        const auto record = record_in(f);
        if (!record) return;
        out.seconds += record->seconds;
        for (const auto& [port, o] : record->outputs)
          if (o.small) {
            ++out.in_records;
            ++out.by_type[o.type].count;
          }
      } else if (f.name && name == "values") {
        add(out.values, f);
        const auto summary = value_summary(f.path);
        add(out.by_type[summary ? summary->type : "damaged"], f);
      } else {
        add(out.other, f);
      }
    });
  return out;
}

namespace {

struct Entries {
  std::vector<CacheFile> values, records;
  std::uint64_t value_bytes = 0, record_bytes = 0, other_bytes = 0;
  std::uint64_t bytes() const { return value_bytes + record_bytes + other_bytes; }
};

// Lists the entries in one part of the tables, or in all parts, and removes worthless files on the way.
Entries look_through(const fs::path& folder, int part, Collected& out) {
  Entries all;
  for (const std::string table : kCacheTables)
    each_cache_file(folder, table.c_str(), part, [&](const CacheFile& f) {
      if (remove_worthless(folder, table.c_str(), f, out)) return;
      if (f.name && table == "values") {
        all.values.push_back(f);
        all.value_bytes += f.bytes;
      } else if (f.name && table == "actions") {
        all.records.push_back(f);
        all.record_bytes += f.bytes;
      } else
        all.other_bytes += f.bytes;
    });
  return all;
}

// Removes entries down to `limit` bytes. Removes records, least recently used first, only as long as they
// take more than a quarter of the limit; then values by the seconds of computing that they save per byte and
// day unused.
void reduce(Entries& all, double limit, Collected& out) {
  const auto drop = [&](const CacheFile& f, std::uint64_t& count, std::uint64_t& bytes) {
    if (removed(f.path)) {
      ++count;
      out.bytes += f.bytes;
      bytes -= f.bytes;
    }
  };
  const auto over = [&] { return all.bytes() > limit; };
  if (over()) {
    std::sort(all.records.begin(), all.records.end(), [](const CacheFile& a, const CacheFile& b) {
      return std::pair(-a.age, a.name) < std::pair(-b.age, b.name);
    });
    for (const auto& f : all.records) {
      if (!over() || all.record_bytes <= limit / 4) break;
      drop(f, out.records, all.record_bytes);
    }
  }
  if (over()) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < all.values.size(); ++i) {
      const CacheFile& f = all.values[i];
      const auto summary = value_summary(f.path);
      order.emplace_back((summary ? summary->seconds : 0) / (f.bytes + 1) / (f.age / kDay + 1), i);
    }
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return std::pair(a.first, all.values[a.second].name) < std::pair(b.first, all.values[b.second].name);
    });
    for (const auto& [worth, i] : order) {
      if (!over()) break;
      drop(all.values[i], out.values, all.value_bytes);
    }
  }
}

}  // namespace

Collected collect_cache(const fs::path& folder, std::uint64_t limit) {
  Collected out;
  const CacheLock lock(folder);
  if (!lock.held()) {
    out.busy = true;
    return out;
  }
  Entries all = look_through(folder, -1, out);
  if (all.bytes() > limit) reduce(all, 0.9 * limit, out);
  CacheUsage(folder).set(out.left = all.bytes());
  return out;
}

Collected tend_cache(const fs::path& folder, std::uint64_t limit) {
  Collected out;
  const CacheUsage usage(folder);
  std::uint64_t bytes = usage.add(0);
  const bool known = bytes != std::numeric_limits<std::uint64_t>::max();
  Entries found = look_through(folder, usage.next_part(), out);
  if (known) bytes = usage.add(-static_cast<std::int64_t>(out.bytes));
  out.left = bytes;
  if (bytes <= limit) return out;
  // Entries are spread evenly over the parts, so each inspected part is reduced to its share of the limit
  // until enough space is free. A small cache, or one of unknown size, is collected completely.
  constexpr std::size_t kMany = 100;
  if (!known || found.values.size() + found.records.size() < kMany) return collect_cache(folder, limit);
  const CacheLock lock(folder);
  if (!lock.held()) {
    out.busy = true;
    return out;
  }
  const double share = 0.9 * limit / 256;
  for (int k = 0; k < 256 && bytes > 0.995 * limit; ++k) {
    const std::uint64_t before = out.bytes;
    if (k > 0) found = look_through(folder, usage.next_part(), out);
    reduce(found, share, out);
    bytes = usage.add(-static_cast<std::int64_t>(out.bytes - before));
  }
  out.left = bytes;
  return out;
}

void clear_cache(const fs::path& folder) {
  std::string trouble;
  for (const char* table : kCacheTables) {
    each_cache_file(folder, table, -1, [&](const CacheFile& f) {
      std::error_code error;
      fs::remove(f.path, error);
      if (error && trouble.empty()) trouble = "'" + f.path.string() + "': " + error.message();
    });
    // Removes empty folders. A folder that contains a user's file stays.
    std::error_code ignored;
    for (int part = 0; part < 256; ++part) fs::remove(folder / table / fmt::format("{:02x}", part), ignored);
    fs::remove(folder / table, ignored);
  }
  if (!trouble.empty()) throw Error("cache-clear", "cannot remove " + trouble);
  CacheUsage(folder).set(0);
}

namespace {

using SmallValues = std::unordered_map<Hash, OutputRecord>;  // by content

// The request that recomputes a record. Nothing if its node type, inputs or files are not available. `small`:
// the values in records.
std::optional<ComputeRequest> request_again(const ActionRecord& record, const Registry& registry,
                                            Store& store, const SmallValues& small, FileHashes& hashes,
                                            const Work& work) {
  ComputeRequest q;
  q.type = registry.find(record.type);
  if (!q.type || q.type->version != record.version || record.outputs.empty() || q.type->writes_files)
    return {};
  q.parameters = record.parameters;
  for (const auto& [port, list] : record.inputs)
    for (const auto& o : list) {
      const auto in_record = small.find(o.content);
      Value v = store.get_value(in_record == small.end() ? o : in_record->second);
      if (!v) return {};
      q.inputs[port].push_back(std::move(v));
    }
  for (const auto& [name, list] : record.input_files)
    for (const auto& f : list) {
      try {
        if (input_content(*q.type, f.path, hashes, available_memory()) != f.content) return {};
      } catch (const Error&) {  // too large for this machine
        return {};
      }
      q.files[name].push_back(f.path);
    }
  q.work = work;
  return q;
}

}  // namespace

Verified verify_cache(const fs::path& folder, const Registry& registry, const ValueTypes& types,
                      std::uint64_t sample, std::uint64_t seed, const Work& work) {
  Verified out;
  std::vector<std::pair<Hash, std::pair<Hash, std::shared_ptr<const ActionRecord>>>> records;
  each_cache_file(folder, "values", -1, [&](const CacheFile& f) {
    work.check();
    if (!f.name) return;
    ++out.values;
    if (!is_value_of(f.path, f.name, [&] { work.check(); }) && removed(f.path))
      out.damaged.push_back(f.path.string());
  });
  SmallValues small;
  each_cache_file(folder, "actions", -1, [&](const CacheFile& f) {
    work.check();
    if (!f.name) return;
    ++out.records;
    const auto text = read_file(f.path);
    if (!text) return;
    auto record = parse_action(*text);
    const NodeType* type = record ? registry.find(record->type) : nullptr;
    if (!record || (type && type->version == record->version && !has_outputs_of(*record, *type))) {
      if (removed(f.path)) out.damaged.push_back(f.path.string());
      return;
    }
    bool lost = false;
    std::error_code error;
    for (const auto& [port, o] : record->outputs) {
      if (o.small) {
        ++out.values;
        small.emplace(o.content, o);
      }
      lost = lost || (!o.small && !fs::exists(cache_entry(folder, "values", o.content), error));
    }
    out.lost += lost;
    records.push_back({hash_of(f.name.text() + std::to_string(seed)), {f.name, std::move(record)}});
  });
  std::sort(records.begin(), records.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Store store(types, folder);
  FileHashes hashes;
  for (const auto& [order, entry] : records) {
    if (out.recomputed >= sample) break;
    const auto& [key, record] = entry;
    work.progress(static_cast<double>(out.recomputed) / sample, record->type);
    auto request = request_again(*record, registry, store, small, hashes, work);
    if (!request) {
      ++out.passed_over;
      continue;
    }
    const ComputeResult again = compute_node(std::move(*request));
    ++out.recomputed;
    for (const auto& [port, value] : again.outputs) {
      HashWriter w;
      w.text(value.type().name);
      value.type().encode(value.data(), w);
      const auto known = record->outputs.find(port);
      if (known != record->outputs.end() && known->second.content == w.hash()) continue;
      out.differing.push_back(record->type + " " + key.text() + ": " + port);
      store.drop_action(key);
    }
  }
  std::sort(out.damaged.begin(), out.damaged.end());
  return out;
}

}  // namespace terrazzo
