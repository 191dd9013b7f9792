#include "nodes/common/io/checked_file.h"

#include <cerrno>
#include <cstring>
#include <locale>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

Error failure(const char* doing, int reason) {
  return Error("write-failed",
               (doing[0] ? std::string(doing) + ": " : std::string()) +
                   (reason ? std::strerror(reason) : "unknown reason"),
               reason == ENOSPC || reason == EFBIG || reason == EDQUOT
                   ? "free some disk space or choose another folder"
                   : "check the folder and its permissions");
}

}  // namespace

CheckedFile::CheckedFile(const std::filesystem::path& path) {
  errno = 0;
  stream_.imbue(std::locale::classic());  // whatever the host program has set
  stream_.open(path, std::ios::binary | std::ios::trunc);
  if (!stream_) throw failure("", errno);
  stream_.exceptions(std::ios::badbit | std::ios::failbit);
}

void CheckedFile::close() {
  stream_.flush();
  stream_.close();
}

void CheckedFile::fail() const { throw failure("the file is incomplete", errno); }

void write_bytes(const std::filesystem::path& path, std::string_view content) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) { out.write(content.data(), content.size()); });
}

}  // namespace terrazzo
