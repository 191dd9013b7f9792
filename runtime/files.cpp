#include "runtime/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
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

std::optional<Hash> hash_bytes(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.fd < 0) return {};
  HashWriter writer;
  std::vector<char> buffer(1 << 20);
  while (true) {
    const ssize_t n = ::read(file.fd, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return {};
    if (n == 0) return writer.hash();
    writer.bytes(buffer.data(), static_cast<std::size_t>(n));
  }
}

std::int64_t nanoseconds(const struct stat& s) {
  return s.st_mtim.tv_sec * 1'000'000'000 + s.st_mtim.tv_nsec;
}

}  // namespace

std::optional<Hash> FileHashes::hash(const fs::path& path) {
  struct stat s;
  if (::stat(path.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return {};
  const Entry now{static_cast<std::uintmax_t>(s.st_size), nanoseconds(s), {}};
  const std::string name = fs::absolute(path).lexically_normal().string();
  const auto fresh = [&](const Entry& e) { return e.size == now.size && e.time == now.time; };
  const fs::path memo = folder_.empty() ? fs::path() : folder_ / hash_of(name).text();
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = entries_.find(name); it != entries_.end() && fresh(it->second))
      return it->second.hash;
  }
  if (!memo.empty())
    if (const auto text = read_file(memo)) {
      Entry e{};
      char hex[33] = {};
      if (std::sscanf(text->c_str(), "%ju %ld %32s", &e.size, &e.time, hex) == 3 && fresh(e) &&
          (e.hash = Hash::parse(hex))) {
        const std::lock_guard lock(mutex_);
        entries_[name] = e;
        return e.hash;
      }
    }
  auto hash = hash_bytes(path);
  if (!hash) return {};
  // A file younger than the clock's grain could still change without changing its time: not remembered.
  struct timespec clock;
  ::clock_gettime(CLOCK_REALTIME, &clock);
  const bool settled = clock.tv_sec * 1'000'000'000 + clock.tv_nsec - now.time > 50'000'000;
  if (settled) {
    const std::lock_guard lock(mutex_);
    entries_[name] = {now.size, now.time, *hash};
    if (!memo.empty()) try {
        write_text_atomically(memo, fmt::format("{} {} {}\n", now.size, now.time, hash->text()));
      } catch (const Error&) {
        // The memo only saves time; a full or read-only cache must not stop the run.
      }
  }
  return hash;
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

void write_atomically(const fs::path& final, const std::function<void(const fs::path&)>& write) {
  static std::atomic<unsigned> serial{0};
  const auto fail = [&](const std::string& why) {
    throw Error("write-failed", fmt::format("cannot write '{}': {}", final.string(), why));
  };
  std::error_code error;
  if (!final.parent_path().empty()) fs::create_directories(final.parent_path(), error);
  if (error) fail(error.message());
  const fs::path temporary =
      final.parent_path() /
      fmt::format(".{}.{}.{}.tmp{}", final.stem().string(), ::getpid(), ++serial, final.extension().string());
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
