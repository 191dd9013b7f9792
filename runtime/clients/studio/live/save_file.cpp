#include "runtime/clients/studio/live/save_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "graph/diagnostic.h"
#include "runtime/files.h"
#include "runtime/files/descriptor.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

// Creates an empty file. False if the name exists, even as a dangling link.
bool create(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd >= 0) return ::close(fd), true;
  if (errno == EEXIST) return false;
  throw Error("write-failed", fmt::format("cannot create '{}': {}", path.string(), std::strerror(errno)),
              "choose a file in a folder that you can write to");
}

fs::path with_number(const fs::path& name, int number) {
  if (number == 1) return name;
  fs::path out = name;
  out.replace_filename(fmt::format("{}_{}{}", name.stem().string(), number, name.extension().string()));
  return out;
}

// Where the links of a path lead, whether or not a file is there.
fs::path without_links(fs::path path) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(path, error)); ++links) {
    const fs::path to = fs::read_symlink(path, error);
    if (error || links == kMostLinks)
      throw Error("write-failed", fmt::format("cannot follow the link '{}'", path.string()),
                  "choose a file in a folder that you can write to");
    path = path.parent_path() / to;  // `to` alone if it is absolute
  }
  return path;
}

}  // namespace

void give_mode_of(int descriptor, const fs::path& like, const fs::path& final) {
  struct stat own, other;
  if (::stat(like.c_str(), &other) != 0 || !S_ISREG(other.st_mode)) return;
  const auto fail = [&] {
    throw Error("write-failed", fmt::format("cannot write '{}': {}", final.string(), std::strerror(errno)));
  };
  if (::fstat(descriptor, &own) != 0) fail();
  mode_t mode = other.st_mode & 0777;
  // Only root may give the file to its owner. Members of another group must not read it instead.
  if ((own.st_uid != other.st_uid || own.st_gid != other.st_gid) &&
      ::fchown(descriptor, other.st_uid, other.st_gid) != 0 &&
      ::fchown(descriptor, static_cast<uid_t>(-1), other.st_gid) != 0)
    mode &= ~static_cast<mode_t>(S_IRWXG);
  if (::fchmod(descriptor, mode) != 0) fail();
}

void save_text(const fs::path& file, const std::string& text) {
  const fs::path final = without_links(file);
  save_text(final, text, final);
}

void save_text(const fs::path& final, const std::string& text, const fs::path& like) {
  std::error_code error;
  const bool given = fs::is_regular_file(like, error);
  // Private until it has its permissions, which it gets before its text.
  TemporaryFile file(final.parent_path(), final.stem().string().substr(0, 100), final.extension().string(),
                     given ? 0600 : 0666);
  {
    const Descriptor out(::open(file.path().c_str(), O_WRONLY | O_CLOEXEC));
    if (out.fd < 0)
      throw Error("write-failed", fmt::format("cannot write '{}': {}", final.string(), std::strerror(errno)));
    give_mode_of(out.fd, like, final);
    write_all(out.fd, text, final);
  }
  file.rename_to(final);
}

SaveFile SaveFile::numbered(const fs::path& name) {
  SaveFile out(name);
  out.take_next_number();
  return out;
}

SaveFile SaveFile::exactly(const fs::path& name, bool overwrite) {
  SaveFile out(name);
  out.claimed_ = create(name);
  if (!out.claimed_) {
    if (!overwrite)
      throw Error("usage", fmt::format("'{}' already exists", name.string()),
                  "add --overwrite to replace it, or omit --save to create a new file");
    const auto content = read_file(name);
    if (!content) throw Error("usage", fmt::format("cannot read '{}'", name.string()));
    out.left_ = *content;
  }
  out.path_ = name;
  return out;
}

SaveFile::SaveFile(SaveFile&& other) noexcept
    : name_(std::move(other.name_)),
      path_(std::move(other.path_)),
      left_(std::move(other.left_)),
      claimed_(std::exchange(other.claimed_, false)) {}

SaveFile::~SaveFile() {
  std::error_code error;
  // Removes only an empty file, so that content that another program wrote meanwhile stays.
  if (claimed_ && fs::is_regular_file(path_, error) && fs::file_size(path_, error) == 0)
    fs::remove(path_, error);
}

void SaveFile::take_next_number() {
  int number = 1;
  while (!create(with_number(name_, number))) ++number;
  path_ = with_number(name_, number);
  left_.clear();
  claimed_ = true;
}

bool SaveFile::write(const std::function<std::string(const fs::path&)>& text) {
  std::error_code error;
  // If the file was removed, create it again.
  const bool gone = !fs::exists(fs::symlink_status(path_, error));
  if (gone && create(path_)) {
    left_.clear();
    claimed_ = true;
  }
  const bool changed = read_file(path_) != left_;
  if (changed) take_next_number();
  std::string now = text(path_);
  save_text(path_, now);
  left_ = std::move(now);
  claimed_ = false;
  return changed;
}

}  // namespace terrazzo::studio
