#include "runtime/cache/file_hashes.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <vector>

#include "graph/input_file.h"
#include "graph/text/read_number.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/files.h"
#include "runtime/files/host_name.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

std::int64_t nanoseconds(const struct timespec& t) {
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

FileStamp stamp_of(const struct stat& s) {
  return {static_cast<std::uint64_t>(s.st_dev), static_cast<std::uint64_t>(s.st_ino),
          static_cast<std::uint64_t>(s.st_size), nanoseconds(s.st_mtim), nanoseconds(s.st_ctim)};
}

// Whether any change from now on would change the stamp. A file younger than the resolution of its timestamps
// could change without changing them. File systems that store whole seconds have a resolution of up to 2 s.
bool settled(const FileStamp& stamp) {
  struct timespec clock;
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const std::int64_t youngest = std::max(stamp.modified, stamp.changed);
  const bool whole_seconds = stamp.modified % 1'000'000'000 == 0 && stamp.changed % 1'000'000'000 == 0;
  return nanoseconds(clock) - youngest > (whole_seconds ? 2'500'000'000 : 50'000'000);
}

// The hash and stamp of one state of the file. hash_state() returns nothing if the file cannot be read or
// keeps changing.
struct HashedState {
  Hash hash;
  FileStamp stamp;
  bool settled;
};
std::optional<HashedState> hash_state(const fs::path& path) {
  std::vector<char> buffer(1 << 20);
  for (int attempt = 0; attempt < 5; ++attempt) {
    InputFile file(path);
    if (!file) return {};
    const FileStamp stamp = stamp_of(file.status());
    const bool is_settled = settled(stamp);
    HashWriter writer;
    while (const std::size_t n = file.read(buffer.data(), buffer.size())) writer.bytes(buffer.data(), n);
    struct stat after;
    if (!file.trouble().empty() || ::fstat(file.descriptor(), &after) != 0) return {};
    if (stamp_of(after) == stamp) return HashedState{writer.hash(), stamp, is_settled};
  }
  return {};
}

// A stored file hash is trusted without reading the file, so damage must be detectable: the line ends with
// its own hash.
std::string with_check(const std::string& line) { return line + " " + hash_of(line).text() + "\n"; }

// The line without its hash, or "" if the hash does not match.
std::string checked_line(const std::string& text) {
  const std::string line = text.substr(0, text.rfind(' '));
  return with_check(line) == text ? line : "";
}

}  // namespace

std::optional<FileStamp> stamp_of(const fs::path& path) {
  struct stat s;
  if (::stat(path.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return {};
  return stamp_of(s);
}

std::optional<FileHashes::Entry> FileHashes::entry_in(std::string_view line) {
  const auto device = take_number<std::uint64_t>(line), inode = take_number<std::uint64_t>(line),
             size = take_number<std::uint64_t>(line);
  const auto modified = take_number<std::int64_t>(line), changed = take_number<std::int64_t>(line);
  if (!device || !inode || !size || !modified || !changed || !line.starts_with(' ')) return {};
  const Hash hash = Hash::parse(std::string(line.substr(1)));
  if (!hash) return {};
  return Entry{{*device, *inode, *size, *modified, *changed}, hash};
}

std::optional<Hash> FileHashes::hash(const fs::path& path, std::uint64_t most) {
  const auto now = stamp_of(path);
  if (!now) return {};
  const std::string name = fs::absolute(path).lexically_normal().string();
  // A stamp is valid on one machine only: others number their devices differently.
  const Hash entry = hash_of(host_name() + "\n" + name);
  const fs::path memo = folder_.empty() ? fs::path() : cache_entry(folder_, "files", entry);
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = entries_.find(name); it != entries_.end() && it->second.stamp == *now)
      return it->second.hash;
  }
  if (!memo.empty())
    if (const auto text = read_file(memo)) {
      const auto e = entry_in(checked_line(*text));
      if (e && e->stamp == *now) {
        const std::lock_guard lock(mutex_);
        entries_[name] = *e;
        return e->hash;
      }
    }
  require_memory(now->size, most, "the file '" + path.string() + "'");
  const auto state = hash_state(path);
  if (!state) return {};
  if (state->settled) {
    const std::lock_guard lock(mutex_);
    entries_[name] = {state->stamp, state->hash};
    const FileStamp& s = state->stamp;
    if (!memo.empty()) try {
        CacheUsage(folder_).add(
            write_cache_entry(folder_, "files", entry,
                              with_check(fmt::format("{} {} {} {} {} {}", s.device, s.inode, s.size,
                                                     s.modified, s.changed, state->hash.text()))));
      } catch (const Error&) {
        // Storing the hash only saves time, so a full or read-only cache must not stop the run.
      }
  }
  return state->hash;
}

}  // namespace terrazzo
