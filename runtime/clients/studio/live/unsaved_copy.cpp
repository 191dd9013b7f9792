#include "runtime/clients/studio/live/unsaved_copy.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "graph/document/raw_document.h"
#include "graph/input_file.h"
#include "graph/text/read_number.h"
#include "graph/text/utf8.h"
#include "runtime/clients/studio/live/save_file.h"
#include "runtime/files.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

constexpr int kMostCopies = 1000;

std::string first_name(const fs::path& file) { return "." + file.filename().string() + ".unsaved"; }

fs::path copy_name(const fs::path& file, int number) {
  const std::string name = first_name(file);
  return file.parent_path() / (number == 1 ? name : fmt::format("{}_{}", name, number));
}

bool is_copy_name(const fs::path& file, const std::string& name) {
  const std::string first = first_name(file);
  if (name == first) return true;
  if (!name.starts_with(first + "_")) return false;
  const auto number = number_in_text<int>(std::string_view(name).substr(first.size() + 1));
  return number && *number > 1;
}

// Whether the lock is held now. True where the file system has no locks, as on some network mounts.
bool lock(int descriptor) { return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }

[[noreturn]] void cannot_write(const fs::path& path) {
  throw Error("write-failed", fmt::format("cannot write '{}': {}", path.string(), std::strerror(errno)));
}

// The copies beside a file, the one that changed last first.
std::vector<fs::path> copies_beside(const fs::path& file) {
  std::vector<std::pair<fs::file_time_type, fs::path>> found;
  std::error_code error;
  for (fs::directory_iterator it(file.parent_path(), error), end; !error && it != end; it.increment(error))
    if (is_copy_name(file, it->path().filename().string())) {
      std::error_code ignored;
      found.emplace_back(fs::last_write_time(it->path(), ignored), it->path());
    }
  std::sort(found.begin(), found.end(), std::greater<>());
  std::vector<fs::path> out;
  for (auto& [time, path] : found) out.push_back(std::move(path));
  return out;
}

}  // namespace

UnsavedCopy::UnsavedCopy(UnsavedCopy&& other) noexcept
    : file_(std::move(other.file_)),
      path_(std::exchange(other.path_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

UnsavedCopy& UnsavedCopy::operator=(UnsavedCopy&& other) noexcept {
  if (this == &other) return *this;
  give_up();
  file_ = std::move(other.file_);
  path_ = std::exchange(other.path_, {});
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

UnsavedCopy::~UnsavedCopy() { give_up(); }

void UnsavedCopy::give_up() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  path_.clear();
}

// Another program may have replaced or removed the file between opening and locking it.
bool UnsavedCopy::is_in_place() const {
  struct stat ours, there;
  return ::fstat(descriptor_, &ours) == 0 && S_ISREG(ours.st_mode) && ::stat(path_.c_str(), &there) == 0 &&
         ours.st_dev == there.st_dev && ours.st_ino == there.st_ino;
}

// Nothing if another program holds the copy, or if it is no regular file. errno is EEXIST if `create` and the
// name is taken.
std::optional<UnsavedCopy> UnsavedCopy::take(const fs::path& file, const fs::path& copy, bool create) {
  UnsavedCopy out(file);
  out.path_ = copy;
  const int flags = O_RDWR | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC | (create ? O_CREAT | O_EXCL : 0);
  out.descriptor_ = ::open(copy.c_str(), flags, 0600);
  if (out.descriptor_ < 0) return {};
  if (lock(out.descriptor_) && out.is_in_place()) return out;
  out.give_up();
  errno = EEXIST;
  return {};
}

std::optional<UnsavedCopy> UnsavedCopy::left_beside(const fs::path& file, const std::string& saved,
                                                    std::string& text) {
  for (const auto& path : copies_beside(file)) {
    auto copy = take(file, path, false);
    if (!copy) continue;
    FileText read = read_input_file(path, kMaxGraphBytes);
    if (!read || find_invalid_utf8(read.text) != std::string::npos) continue;
    if (read.text.empty() || read.text == saved) {
      copy->remove();
      continue;
    }
    text = std::move(read.text);
    return copy;
  }
  return {};
}

void UnsavedCopy::take_free_name() {
  for (int number = 1; number <= kMostCopies; ++number) {
    const fs::path name = copy_name(file_, number);
    if (auto copy = take(file_, name, true)) {
      *this = std::move(*copy);
      return;
    }
    if (errno != EEXIST) cannot_write(name);
  }
  throw Error("write-failed", fmt::format("there are {} copies beside '{}'", kMostCopies, file_.string()));
}

void UnsavedCopy::write(const std::string& text) {
  if (descriptor_ < 0 || !is_in_place()) {
    give_up();
    take_free_name();
  }
  TemporaryFile next(path_.parent_path(), path_.filename().string().substr(0, 100), {}, 0600);
  const int descriptor = ::open(next.path().c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) cannot_write(path_);
  const int before = std::exchange(descriptor_, descriptor);
  try {
    lock(descriptor_);  // before it has its name, so that nobody else takes it
    give_mode_of(descriptor_, file_, path_);
    // A copy that its owner could not open would not be offered after a crash.
    if (struct stat s; ::fstat(descriptor_, &s) == 0) ::fchmod(descriptor_, (s.st_mode & 0777) | 0600);
    write_all(descriptor_, text, path_);
    next.rename_to(path_);
  } catch (const Error&) {
    ::close(std::exchange(descriptor_, before));
    throw;
  }
  ::close(before);
}

void UnsavedCopy::remove() {
  if (descriptor_ >= 0 && is_in_place()) ::unlink(path_.c_str());
  give_up();
}

}  // namespace terrazzo::studio
