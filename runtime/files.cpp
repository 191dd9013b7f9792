#include "runtime/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cinttypes>
#include <cstring>

namespace terrazzo {
namespace fs = std::filesystem;

std::vector<fs::path> expand_glob(const fs::path& pattern) {
  std::vector<fs::path> found{pattern.root_path()};
  for (const auto& part : pattern.relative_path()) {
    std::vector<fs::path> next;
    const std::string name = part.string();
    const bool glob = name.find_first_of("*?[") != std::string::npos;
    for (const auto& base : found) {
      std::error_code error;
      // A file whose own name holds such characters is meant literally.
      if (fs::exists(base / part, error)) {
        next.push_back(base / part);
      } else if (glob) {
        for (const auto& entry :
             fs::directory_iterator(base, fs::directory_options::skip_permission_denied, error))
          if (fnmatch(name.c_str(), entry.path().filename().c_str(), FNM_PERIOD) == 0)
            next.push_back(entry.path());
      }
    }
    found = std::move(next);
  }
  std::erase_if(found, [](const fs::path& p) {
    std::error_code error;
    return fs::is_directory(p, error);
  });
  std::sort(found.begin(), found.end());
  return found;
}

namespace {

struct Descriptor {
  int fd;
  explicit Descriptor(int fd) : fd(fd) {}
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

std::int64_t nanoseconds(const struct timespec& t) {
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

FileStamp stamp_of(const struct stat& s) {
  return {static_cast<std::uint64_t>(s.st_dev), static_cast<std::uint64_t>(s.st_ino),
          static_cast<std::uint64_t>(s.st_size), nanoseconds(s.st_mtim), nanoseconds(s.st_ctim)};
}

// Whether a change from now on would show in the stamp: a file younger than the grain of its times could change
// without changing them. File systems that keep no fractions of a second have grains of up to 2 s.
bool settled(const FileStamp& stamp) {
  struct timespec clock;
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const std::int64_t youngest = std::max(stamp.modified, stamp.changed);
  const bool whole_seconds =
      stamp.modified % 1'000'000'000 == 0 && stamp.changed % 1'000'000'000 == 0;
  return nanoseconds(clock) - youngest > (whole_seconds ? 2'500'000'000 : 50'000'000);
}

// The hash of one state of the file, and its stamp. Nothing if the file cannot be read or keeps changing.
struct HashedState {
  Hash hash;
  FileStamp stamp;
  bool settled;
};
std::optional<HashedState> hash_state(const fs::path& path) {
  std::vector<char> buffer(1 << 20);
  for (int attempt = 0; attempt < 5; ++attempt) {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat before, after;
    if (file.fd < 0 || ::fstat(file.fd, &before) != 0 || !S_ISREG(before.st_mode)) return {};
    const FileStamp stamp = stamp_of(before);
    const bool is_settled = settled(stamp);
    HashWriter writer;
    while (true) {
      const ssize_t n = ::read(file.fd, buffer.data(), buffer.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return {};
      if (n == 0) break;
      writer.bytes(buffer.data(), static_cast<std::size_t>(n));
    }
    if (::fstat(file.fd, &after) != 0) return {};
    if (stamp_of(after) == stamp) return HashedState{writer.hash(), stamp, is_settled};
  }
  return {};
}

}  // namespace

std::optional<FileStamp> stamp_of(const fs::path& path) {
  struct stat s;
  if (::stat(path.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return {};
  return stamp_of(s);
}

std::optional<Hash> FileHashes::hash(const fs::path& path) {
  const auto now = stamp_of(path);
  if (!now) return {};
  const std::string name = fs::absolute(path).lexically_normal().string();
  const fs::path memo = folder_.empty() ? fs::path() : folder_ / hash_of(name).text();
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = entries_.find(name); it != entries_.end() && it->second.stamp == *now)
      return it->second.hash;
  }
  if (!memo.empty())
    if (const auto text = read_file(memo)) {
      Entry e{};
      char hex[33] = {};
      if (std::sscanf(text->c_str(), "%" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNd64 " %" SCNd64 " %32s",
                      &e.stamp.device, &e.stamp.inode, &e.stamp.size, &e.stamp.modified, &e.stamp.changed,
                      hex) == 6 &&
          e.stamp == *now && (e.hash = Hash::parse(hex))) {
        const std::lock_guard lock(mutex_);
        entries_[name] = e;
        return e.hash;
      }
    }
  const auto state = hash_state(path);
  if (!state) return {};
  if (state->settled) {
    const std::lock_guard lock(mutex_);
    entries_[name] = {state->stamp, state->hash};
    const FileStamp& s = state->stamp;
    if (!memo.empty()) try {
        write_text_atomically(memo, fmt::format("{} {} {} {} {} {}\n", s.device, s.inode, s.size, s.modified,
                                                s.changed, state->hash.text()));
      } catch (const Error&) {
        // The memo only saves time; a full or read-only cache must not stop the run.
      }
  }
  return state->hash;
}

std::optional<std::string> read_file(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat s;
  if (file.fd < 0 || ::fstat(file.fd, &s) != 0 || !S_ISREG(s.st_mode)) return {};
  std::string out(static_cast<std::size_t>(s.st_size), '\0');
  std::size_t got = 0;
  while (got < out.size()) {
    const ssize_t n = ::read(file.fd, out.data() + got, out.size() - got);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return {};
    got += static_cast<std::size_t>(n);
  }
  return out;
}

namespace {

// Distinct on every host and in every container: their process ids may be equal.
std::string temporary_name(const fs::path& final) {
  static const std::string host = [] {
    char name[65] = {};
    ::gethostname(name, sizeof name - 1);
    std::string out;
    for (const char* c = name; *c && out.size() < 24; ++c)
      if (std::isalnum(static_cast<unsigned char>(*c)) || *c == '-') out += *c;
    return out.empty() ? "host" : out;
  }();
  std::uint64_t bits = 0;
  if (::getrandom(&bits, sizeof bits, 0) != sizeof bits)
    throw Error("write-failed", "the system gives no random numbers");
  return fmt::format(".{}.{}.{}.{:016x}.tmp{}", final.stem().string().substr(0, 100), host, ::getpid(), bits,
                     final.extension().string());
}

}  // namespace

void write_atomically(const fs::path& final, const std::function<void(const fs::path&)>& write) {
  const auto fail = [&](const std::string& why) {
    throw Error("write-failed", fmt::format("cannot write '{}': {}", final.string(), why));
  };
  std::error_code error;
  const fs::path folder = final.parent_path();
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error) fail(error.message());
  fs::path temporary;
  for (int attempt = 0; temporary.empty(); ++attempt) {
    const fs::path candidate = folder / temporary_name(final);
    const Descriptor made(::open(candidate.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (made.fd >= 0)
      temporary = candidate;
    else if (errno != EEXIST || attempt == 100)
      fail(std::strerror(errno));
  }
  struct Remover {
    const fs::path& path;
    ~Remover() {
      std::error_code ignored;
      fs::remove(path, ignored);  // gone already after the rename
    }
  } remover{temporary};
  write(temporary);
  {
    const Descriptor file(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.fd < 0) fail(std::strerror(errno));
    if (::fsync(file.fd) != 0) fail(std::strerror(errno));
  }
  fs::rename(temporary, final, error);
  if (error) fail(error.message());
  sync_folder(folder);
}

void sync_folder(const fs::path& folder) {
  const Descriptor directory(
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some network file systems cannot sync a folder; the file in it is whole all the same.
  if (directory.fd >= 0) ::fsync(directory.fd);
}

void write_text_atomically(const fs::path& final, const std::string& text) {
  write_atomically(final, [&](const fs::path& temporary) {
    const Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    std::size_t done = 0;
    while (file.fd >= 0 && done < text.size()) {
      const ssize_t n = ::write(file.fd, text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) break;
      done += static_cast<std::size_t>(n);
    }
    if (file.fd < 0 || done < text.size())
      throw Error("write-failed", fmt::format("cannot write '{}': {}", final.string(), std::strerror(errno)));
  });
}

}  // namespace terrazzo
