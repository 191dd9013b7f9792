#include "graph/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace terrazzo {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "it is a folder";
  if (S_ISFIFO(mode)) return "it is a pipe, and only regular files are read";
  if (S_ISSOCK(mode)) return "it is a socket, and only regular files are read";
  return "it is a device, and only regular files are read";
}

}  // namespace

InputFile::InputFile(const std::filesystem::path& path) {
  // Looked at first, because opening some devices has an effect. O_NONBLOCK: a pipe may have taken its place.
  if (::stat(path.c_str(), &status_) != 0) {
    trouble_ = std::strerror(errno);
    return;
  }
  if (S_ISREG(status_.st_mode)) {
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0 || ::fstat(descriptor_, &status_) != 0) trouble_ = std::strerror(errno);
  }
  if (trouble_.empty() && !S_ISREG(status_.st_mode)) trouble_ = kind_of(status_.st_mode);
  if (trouble_.empty() && has_content_without_size())
    trouble_ = "it has no size, and only regular files are read";
  if (trouble_.empty() || descriptor_ < 0) return;
  ::close(descriptor_);
  descriptor_ = -1;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

// Files in /proc say that they are empty.
bool InputFile::has_content_without_size() {
  char byte;
  return status_.st_size == 0 && ::pread(descriptor_, &byte, 1, 0) == 1 &&
         ::fstat(descriptor_, &status_) == 0 && status_.st_size == 0;
}

std::size_t InputFile::read(char* to, std::size_t bytes) {
  std::size_t got = 0;
  while (got < bytes) {
    const ssize_t n = ::read(descriptor_, to + got, bytes - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) trouble_ = std::strerror(errno);
    if (n <= 0) break;
    got += n;
  }
  return got;
}

FileText read_input_file(const std::filesystem::path& path, std::uint64_t most_bytes) {
  InputFile file(path);
  FileText out;
  if (!file) {
    out.trouble = file.trouble();
    return out;
  }
  if (file.size() > most_bytes) {
    out.too_large = true;
    out.trouble = fmt::format("it has {} bytes, and at most {} are read", file.size(), most_bytes);
    return out;
  }
  out.text.resize(file.size());
  if (file.read(out.text.data(), out.text.size()) == out.text.size()) return out;
  out.trouble = file.trouble().empty() ? "it became shorter while it was read" : file.trouble();
  out.text.clear();
  return out;
}

std::string read_beginning(const std::filesystem::path& path, std::size_t bytes) {
  InputFile file(path);
  if (!file) return "";
  std::string out(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, file.size())), '\0');
  out.resize(file.read(out.data(), out.size()));
  return out;
}

}  // namespace terrazzo
