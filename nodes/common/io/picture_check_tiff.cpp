#include <fmt/format.h>

#include <iterator>
#include <map>
#include <set>

#include "nodes/common/io/picture_check.h"

namespace terrazzo {
namespace {

// Reads numbers of a TIFF file in its byte order and width.
class Tiff {
 public:
  explicit Tiff(std::string_view content) : content_(content), little_(content[0] == 'I') {
    big_ = number(2, 2) == 43;
  }
  bool is_big() const { return big_; }
  std::uint64_t number(std::uint64_t at, int bytes) const {
    if (at > content_.size() || content_.size() - at < static_cast<std::uint64_t>(bytes))
      damaged_picture(fmt::format("it is truncated: it refers to byte {} of {}", at, content_.size()));
    std::uint64_t v = 0;
    for (int k = 0; k < bytes; ++k) {
      const auto byte =
          static_cast<unsigned char>(content_[at + static_cast<std::uint64_t>(little_ ? bytes - 1 - k : k)]);
      v = v << 8 | byte;
    }
    return v;
  }
  std::uint64_t size() const { return content_.size(); }

 private:
  std::string_view content_;
  bool little_, big_ = false;
};

struct Entry {
  int width = 0;  // bytes per number
  std::uint64_t count = 0, at = 0;
};

int width_of(std::uint64_t type) {
  constexpr int widths[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < std::size(widths) ? widths[type] : 0;
}

void check_blocks(const Tiff& in, const std::map<std::uint64_t, Entry>& entries, std::uint64_t offsets,
                  std::uint64_t lengths) {
  const auto o = entries.find(offsets), l = entries.find(lengths);
  if (o == entries.end() || l == entries.end()) return;
  const std::uint64_t n = std::min(o->second.count, l->second.count);
  for (std::uint64_t i = 0; i < n; ++i) {
    const auto value = [&](const Entry& e) {
      return in.number(e.at + i * static_cast<std::uint64_t>(e.width), e.width);
    };
    const std::uint64_t at = value(o->second), length = value(l->second);
    if (at > in.size() || length > in.size() - at)
      damaged_picture(fmt::format("it is truncated: its block {} of {} ends at byte {} of {}", i, n,
                                  static_cast<double>(at) + static_cast<double>(length), in.size()));
  }
}

}  // namespace

void check_tiff(std::string_view content, const Reading&) {
  if (content.size() < 8) damaged_picture("it is truncated");
  const Tiff in(content);
  const int word = in.is_big() ? 8 : 4;  // bytes per offset and count
  const std::uint64_t entry_size = in.is_big() ? 20 : 12;
  std::set<std::uint64_t> seen;
  std::uint64_t at = in.number(in.is_big() ? 8 : 4, word);
  while (at != 0 && seen.insert(at).second) {
    const std::uint64_t n = in.number(at, in.is_big() ? 8 : 2);
    const std::uint64_t first = at + (in.is_big() ? 8 : 2);
    if (n > in.size() / entry_size)
      damaged_picture(fmt::format("its directory has {} entries, which exceed the file", n));
    std::map<std::uint64_t, Entry> entries;
    for (std::uint64_t i = 0; i < n; ++i) {
      const std::uint64_t e = first + i * entry_size;
      const std::uint64_t tag = in.number(e, 2);
      Entry entry{width_of(in.number(e + 2, 2)), in.number(e + 4, word),
                  e + 4 + static_cast<std::uint64_t>(word)};
      if (entry.count > in.size())
        damaged_picture(fmt::format("its entry {} has {} values", tag, entry.count));
      const std::uint64_t bytes = entry.count * static_cast<std::uint64_t>(entry.width);
      if (bytes > static_cast<std::uint64_t>(word)) {
        entry.at = in.number(entry.at, word);
        if (entry.at > in.size() || bytes > in.size() - entry.at)
          damaged_picture(fmt::format("it is truncated: its entry {} ends beyond byte {}", tag, in.size()));
      }
      if (tag != 273 && tag != 279 && tag != 324 && tag != 325)
        continue;  // offsets and lengths of strips and tiles
      if (entry.width == 0) damaged_picture(fmt::format("its entry {} has an invalid type", tag));
      entries[tag] = entry;
    }
    check_blocks(in, entries, 273, 279);
    check_blocks(in, entries, 324, 325);
    at = in.number(first + n * entry_size, word);
  }
}

}  // namespace terrazzo
