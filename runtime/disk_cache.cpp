#include "runtime/disk_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <unordered_map>

#include "runtime/action_key.h"
#include "runtime/compute_node.h"
#include "runtime/files.h"
#include "runtime/store.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

struct Found {
  fs::path path;
  Hash name;  // zero where the file is none of ours
  std::uint64_t bytes;
  double age;  // seconds since its last use
};

// Files that go while we look are no mistake.
void each_file(const fs::path& folder, const std::function<void(const Found&)>& use) {
  struct timespec now;
  ::clock_gettime(CLOCK_REALTIME, &now);
  std::error_code error;
  for (auto it =
           fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
       !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    struct stat s;
    if (::lstat(it->path().c_str(), &s) != 0 || !S_ISREG(s.st_mode)) continue;
    const std::string name = it->path().filename().string();
    use({it->path(), name.size() == 32 ? Hash::parse(name) : Hash{}, static_cast<std::uint64_t>(s.st_size),
         static_cast<double>(now.tv_sec - s.st_mtim.tv_sec)});
  }
}

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

class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : fd_(::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    held_ = fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0;
  }
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool held() const { return held_; }

 private:
  int fd_;
  bool held_;
};

}  // namespace

CacheStats cache_stats(const fs::path& folder) {
  CacheStats out;
  const auto add = [](CacheStats::Kind& k, const Found& f) { ++k.count, k.bytes += f.bytes; };
  each_file(folder, [&](const Found& f) {
    const std::string table = f.path.lexically_relative(folder).begin()->string();
    if (f.name && table == "actions") {
      add(out.records, f);
      if (const auto text = read_file(f.path))
        if (const auto record = parse_action(*text)) out.seconds += record->seconds;
    } else if (f.name && table == "values") {
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
  const FolderLock lock(folder);
  if (!lock.held()) return out.busy = true, out;

  std::vector<Found> values;
  each_file(folder / "values", [&](const Found& f) {
    if (f.name)
      values.push_back(f), out.left += f.bytes;
    else if (f.age > hour && removed(f.path))  // younger ones may still be written to
      ++out.leftovers, out.bytes += f.bytes;
  });
  std::unordered_map<Hash, double> seconds;  // that a value saves
  struct Record {
    Found file;
    std::vector<Hash> outputs;
  };
  std::vector<Record> records;
  each_file(folder / "actions", [&](const Found& f) {
    const auto text = f.name ? read_file(f.path) : std::nullopt;
    const auto record = text ? parse_action(*text) : nullptr;
    if (!record) {
      if (f.age > hour && removed(f.path)) ++out.leftovers, out.bytes += f.bytes;
      return;
    }
    records.push_back({f, {}});
    for (const auto& [port, o] : record->outputs) {
      double& s = seconds[o.content];
      s = std::max(s, record->seconds);
      records.back().outputs.push_back(o.content);
    }
  });

  if (out.left > limit) {
    const auto worth = [&](const Found& f) {
      const auto it = seconds.find(f.name);
      const double saved = it == seconds.end() ? 0 : it->second;
      return saved / (static_cast<double>(f.bytes) + 1) / (f.age / day + 1);
    };
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < values.size(); ++i) order.emplace_back(worth(values[i]), i);
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return std::pair(a.first, values[a.second].name) < std::pair(b.first, values[b.second].name);
    });
    for (const auto& [w, i] : order) {
      if (static_cast<double>(out.left) <= 0.9 * static_cast<double>(limit)) break;
      if (!removed(values[i].path)) continue;
      ++out.values, out.bytes += values[i].bytes, out.left -= values[i].bytes;
    }
  }
  for (const auto& r : records) {
    std::error_code error;
    const bool any = std::any_of(r.outputs.begin(), r.outputs.end(),
                                 [&](const Hash& h) { return fs::exists(value_path(folder, h), error); });
    if (!any && r.file.age > 90 * day && removed(r.file.path)) ++out.records, out.bytes += r.file.bytes;
  }
  for (const char* table : {"files", "history"})
    each_file(folder / table, [&](const Found& f) {
      if (f.age > (f.name ? 90 * day : hour) && removed(f.path)) ++out.leftovers, out.bytes += f.bytes;
    });
  return out;
}

void clear_cache(const fs::path& folder) {
  for (const char* table : {"actions", "values", "files", "history", "lock"}) {
    std::error_code error;
    fs::remove_all(folder / table, error);
    if (error)
      throw Error("cache-clear", "cannot remove '" + (folder / table).string() + "': " + error.message());
  }
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
  each_file(folder / "values", [&](const Found& f) {
    work.check();
    if (!f.name) return;
    ++out.values;
    const auto text = read_file(f.path);
    if (text && value_payload(*text, f.name).empty() && removed(f.path))
      out.damaged.push_back(f.path.string());
  });
  each_file(folder / "actions", [&](const Found& f) {
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
