#include "nodes/common/io/vdb_header.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

Error damaged(const std::string& what) {
  return Error("unreadable-volume", what, "check that the file is complete");
}

constexpr std::int64_t kMagic = 0x56444220;
constexpr std::uint32_t kOldest = 222;  // older versions store compression elsewhere (OpenVDB 1, until 2013)

}  // namespace

std::string_view ByteCursor::take(std::uint64_t bytes) {
  if (bytes > all_.size() - at_)
    throw damaged(fmt::format("at byte {} of {} it needs {} more bytes", at_, all_.size(), bytes));
  const auto found = all_.substr(at_, bytes);
  at_ += bytes;
  return found;
}

void ByteCursor::seek(std::uint64_t at) {
  if (at > all_.size()) throw damaged(fmt::format("it refers to byte {} of {}", at, all_.size()));
  at_ = at;
}

VdbMetadataMap take_vdb_metadata(ByteCursor& in) {
  VdbMetadataMap map;
  for (std::uint32_t left = in.take<std::uint32_t>(); left > 0; --left) {
    const std::string name(in.text());
    const auto type = in.text();
    map[name] = {type, in.text()};
  }
  return map;
}

VdbHeader read_vdb_header(std::string_view bytes) {
  ByteCursor in(bytes);
  VdbHeader h;
  if (in.take<std::int64_t>() != kMagic) throw damaged("it does not begin as an OpenVDB file");
  h.format = in.take<std::uint32_t>();
  if (h.format < kOldest)
    throw Error("unreadable-volume",
                fmt::format("its format version {} is older than {} (OpenVDB 2)", h.format, kOldest),
                "convert it with a newer program");
  h.major = in.take<std::uint32_t>();
  h.minor = in.take<std::uint32_t>();
  h.has_offsets = in.take<char>() != 0;
  in.take(36);  // the file's UUID
  h.metadata = take_vdb_metadata(in);
  h.grids = in.take<std::uint32_t>();
  h.end = in.at();
  return h;
}

}  // namespace terrazzo
