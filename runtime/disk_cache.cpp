#include "runtime/disk_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <unordered_map>

#include "runtime/action_key.h"
#include "runtime/cache_folder.h"
#include "runtime/compute_node.h"
#include "runtime/files.h"
#include "runtime/store.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

// The type's name, which a value file begins with.
std::string type_in(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  char head[16];
  std::uint64_t length = 0;
  if (!in.read(head, sizeof head)) return "?";
  std::memcpy(&length, head + 8, sizeof length);
  std::string name(std::min<std::uint64_t>(length, 64), '\0');
  return in.read(name.data(), static_cast<std::streamsize>(name.size())) ? name : "?";
}

bool removed(const fs::path& path) {
  std::error_code error;
  return fs::remove(path, error);
}

constexpr double hour = 3600, day = 24 * hour;

std::shared_ptr<const ActionRecord> record_in(const CacheFile& f) {
  const auto text = f.name ? read_file(f.path) : std::nullopt;
  return text ? parse_action(*text) : nullptr;
}

bool any_value_of(const fs::path& folder, const ActionRecord& record) {
  std::error_code error;
  for (const auto& [port, o] : record.outputs)
    if (fs::exists(cache_entry(folder, "values", o.content), error)) return true;
  return false;
}

// What nobody misses: what writers that were interrupted left, and what 90 days without use made worthless.
// True if it was removed.
bool remove_worthless(const fs::path& folder, const char* table, const CacheFile& f, Collected& out) {
  if (f.age <= (f.name ? 90 * day : hour)) return false;  // younger leftovers may still be written to
  const std::string name = table;
  if (f.name && name == "values") return false;
  const bool is_record = f.name && name == "actions";
  if (is_record)
    if (const auto record = record_in(f); record && any_value_of(folder, *record)) return false;
  if (!removed(f.path)) return false;
  ++(is_record ? out.records : out.leftovers), out.bytes += f.bytes;
  return true;
}

}  // namespace

CacheStats cache_stats(const fs::path& folder) {
  CacheStats out;
  const auto add = [](CacheStats::Kind& k, const CacheFile& f) { ++k.count, k.bytes += f.bytes; };
  for (const char* table : cache_tables)
    each_cache_file(folder, table, -1, [&](const CacheFile& f) {
      const std::string name = table;
      if (f.name && name == "actions") {
        add(out.records, f);
        if (const auto record = record_in(f)) out.seconds += record->seconds;
      } else if (f.name && name == "values") {
        add(out.values, f);
        add(out.by_type[type_in(f.path)], f);
      } else {
        add(out.other, f);
      }
    });
  return out;
}

Collected collect_cache(const fs::path& folder, std::uint64_t limit) {
  Collected out;
  const CacheLock lock(folder);
  if (!lock.held()) return out.busy = true, out;

  struct Entry {
    CacheFile file;
    double seconds;
    bool is_value;
  };
  std::vector<Entry> entries;
  std::unordered_map<Hash, double> seconds;  // that a value saves
  for (const char* table : cache_tables)
    each_cache_file(folder, table, -1, [&](const CacheFile& f) {
      if (remove_worthless(folder, table, f, out)) return;
      out.left += f.bytes;
      if (!f.name) return;
      if (table == std::string("values")) return entries.push_back({f, 0, true});
      if (table != std::string("actions")) return;
      const auto record = record_in(f);
      entries.push_back({f, record ? record->seconds : 0, false});
      if (!record) return;
      for (const auto& [port, o] : record->outputs) {
        double& s = seconds[o.content];
        s = std::max(s, record->seconds);
      }
    });
  if (out.left > limit) {
    const auto worth = [&](const Entry& e) {
      const auto it = e.is_value ? seconds.find(e.file.name) : seconds.end();
      const double saved = it != seconds.end() ? it->second : e.seconds;
      return saved / (static_cast<double>(e.file.bytes) + 1) / (e.file.age / day + 1);
    };
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < entries.size(); ++i) order.emplace_back(worth(entries[i]), i);
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return std::pair(a.first, entries[a.second].file.name) <
             std::pair(b.first, entries[b.second].file.name);
    });
    for (const auto& [w, i] : order) {
      if (static_cast<double>(out.left) <= 0.9 * static_cast<double>(limit)) break;
      const Entry& e = entries[i];
      if (!removed(e.file.path)) continue;
      ++(e.is_value ? out.values : out.records), out.bytes += e.file.bytes, out.left -= e.file.bytes;
    }
  }
  CacheUsage(folder).set(out.left);
  return out;
}

Collected tend_cache(const fs::path& folder, std::uint64_t limit) {
  const CacheUsage usage(folder);
  const std::uint64_t bytes = usage.add(0);
  if (bytes > limit) return collect_cache(folder, limit);
  Collected out;
  const int part = usage.next_part();
  for (const char* table : cache_tables)
    each_cache_file(folder, table, part,
                    [&](const CacheFile& f) { remove_worthless(folder, table, f, out); });
  if (out.bytes > 0) usage.add(-static_cast<std::int64_t>(out.bytes));
  out.left = bytes - std::min(bytes, out.bytes);
  return out;
}

void clear_cache(const fs::path& folder) {
  std::string trouble;
  for (const char* table : cache_tables) {
    each_cache_file(folder, table, -1, [&](const CacheFile& f) {
      std::error_code error;
      fs::remove(f.path, error);
      if (error && trouble.empty()) trouble = "'" + f.path.string() + "': " + error.message();
    });
    // Folders that are empty now; one with a file of the user's in it stays.
    std::error_code ignored;
    for (int part = 0; part < 256; ++part) fs::remove(folder / table / fmt::format("{:02x}", part), ignored);
    fs::remove(folder / table, ignored);
  }
  if (!trouble.empty()) throw Error("cache-clear", "cannot remove " + trouble);
  CacheUsage(folder).set(0);
}

namespace {

// What is needed to compute a record again; nothing where that cannot be done here and now.
std::optional<ComputeRequest> request_again(const ActionRecord& record, const Registry& registry,
                                            Store& store, FileHashes& hashes, const Work& work) {
  ComputeRequest q;
  q.type = registry.find(record.type);
  if (!q.type || q.type->version != record.version || record.outputs.empty() || q.type->writes_files)
    return {};
  q.parameters = record.parameters;
  for (const auto& [port, list] : record.inputs)
    for (const auto& o : list) {
      Value v = store.get_value(o);
      if (!v) return {};
      q.inputs[port].push_back(std::move(v));
    }
  for (const auto& [name, list] : record.input_files)
    for (const auto& f : list) {
      if (input_content(*q.type, f.path, hashes) != f.content) return {};
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
    const auto text = read_file(f.path);
    if (text && value_payload(*text, f.name).empty() && removed(f.path))
      out.damaged.push_back(f.path.string());
  });
  each_cache_file(folder, "actions", -1, [&](const CacheFile& f) {
    work.check();
    if (!f.name) return;
    ++out.records;
    const auto text = read_file(f.path);
    if (!text) return;
    if (auto record = parse_action(*text))
      records.push_back({hash_of(f.name.text() + std::to_string(seed)), {f.name, std::move(record)}});
    else if (removed(f.path))
      out.damaged.push_back(f.path.string());
  });
  std::sort(records.begin(), records.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Store store(types, folder);
  FileHashes hashes;
  for (const auto& [order, entry] : records) {
    if (out.recomputed >= sample) break;
    const auto& [key, record] = entry;
    work.progress(static_cast<double>(out.recomputed) / static_cast<double>(sample), record->type);
    auto request = request_again(*record, registry, store, hashes, work);
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
