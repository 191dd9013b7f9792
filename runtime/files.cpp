#include "runtime/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "graph/input_file.h"
#include "runtime/files/descriptor.h"
#include "runtime/files/host_name.h"
#include "runtime/files/natural_order.h"
#include "runtime/files/protected_files.h"

namespace terrazzo {
namespace fs = std::filesystem;

bool is_inside(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(path, error);
  return !error &&
         std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end();
}

std::vector<fs::path> expand_glob(const fs::path& pattern) {
  std::vector<fs::path> found{pattern.root_path()};
  for (const auto& part : pattern.relative_path()) {
    std::vector<fs::path> next;
    const std::string name = part.string();
    const bool glob = name.find_first_of("*?[") != std::string::npos;
    for (const auto& base : found) {
      std::error_code error;
      // If a file has exactly this name, wildcard characters included, use that file.
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
  std::sort(found.begin(), found.end(), natural_path_less);
  return found;
}

std::optional<std::string> read_file(const fs::path& path, std::uint64_t most) {
  FileText file = read_input_file(path, most);
  if (!file) return {};
  return std::move(file.text);
}

namespace {

[[noreturn]] void cannot_write(const fs::path& path, const std::string& why) {
  throw Error("write-failed", fmt::format("cannot write '{}': {}", path.string(), why));
}

std::string temporary_name(const std::string& stem, const std::string& extension) {
  std::uint64_t bits = 0;
  if (::getrandom(&bits, sizeof bits, 0) != sizeof bits)
    throw Error("write-failed", "the system provides no random numbers");
  // With the host, because processes on other hosts or in other containers may have the same ID.
  return fmt::format(".{}.{}.{}.{:016x}.tmp{}", stem, host_name(), ::getpid(), bits, extension);
}

void sync_folder(const fs::path& folder) {
  const Descriptor directory(
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some network file systems cannot sync a folder. The file itself is complete anyway.
  if (directory.fd >= 0) ::fsync(directory.fd);
}

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& folder, const std::string& stem, const std::string& extension,
                             unsigned mode) {
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error) cannot_write(folder / (stem + extension), error.message());
  for (int attempt = 0; path_.empty(); ++attempt) {
    const fs::path candidate = folder / temporary_name(stem, extension);
    const Descriptor made(::open(candidate.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
    if (made.fd >= 0)
      path_ = candidate;
    else if (errno != EEXIST || attempt == 100)
      cannot_write(folder / (stem + extension), std::strerror(errno));
  }
}

void require_replaceable(const fs::path& final) {
  std::error_code error;
  const fs::file_status there = fs::status(final, error);
  if (fs::is_directory(there)) cannot_write(final, "it is a folder");
  // Renaming would replace it, not write to it.
  if (fs::exists(there) && !fs::is_regular_file(there)) cannot_write(final, "it is a device or a pipe");
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove(path_, ignored);
}

void TemporaryFile::rename_to(const fs::path& final) {
  {
    const Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.fd < 0 || ::fsync(file.fd) != 0) cannot_write(final, std::strerror(errno));
  }
  require_replaceable(final);
  std::error_code error;
  fs::rename(path_, final, error);
  if (error) cannot_write(final, error.message());
  path_.clear();
  sync_folder(final.parent_path());
}

bool is_temporary_name(const std::string& name, const std::string& stem) {
  if (!name.starts_with("." + stem + ".")) return false;
  std::vector<std::string> parts(1);  // host, pid, bits, "tmp"
  for (const char c : name.substr(stem.size() + 2))
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  const auto only = [](const std::string& text, const char* characters) {
    return !text.empty() && text.find_first_not_of(characters) == std::string::npos;
  };
  return parts.size() == 4 && parts[0].size() <= 24 && only(parts[1], "0123456789") &&
         parts[2].size() == 16 && only(parts[2], "0123456789abcdef") && parts[3] == "tmp";
}

void write_atomically(const fs::path& final, const std::function<void(const fs::path&)>& write) {
  TemporaryFile file(final.parent_path(), final.stem().string().substr(0, 100), final.extension().string());
  write(file.path());
  file.rename_to(final);
}

void write_all(int descriptor, const std::string& text, const fs::path& final) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) cannot_write(final, std::strerror(errno));
    done += n;
  }
}

void write_atomically(const fs::path& final, const ProtectedFiles& keep,
                      const std::function<void(const fs::path&)>& write) {
  keep.require_other(final);
  write_atomically(final, write);
}

void write_text_atomically(const fs::path& final, const ProtectedFiles& keep, const std::string& text) {
  keep.require_other(final);
  write_text_atomically(final, text);
}

void write_text_atomically(const fs::path& final, const std::string& text) {
  write_atomically(final, [&](const fs::path& temporary) {
    const Descriptor file(::open(temporary.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC));
    if (file.fd < 0) cannot_write(final, std::strerror(errno));
    write_all(file.fd, text, final);
  });
}

}  // namespace terrazzo
