#include "nodes/common/io/pictures/tiff_directory.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

constexpr std::uint64_t kMostEntries = 20'000'000;

int width_of(std::uint64_t type) {
  constexpr int kWidths[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < std::size(kWidths) ? kWidths[type] : 0;
}

// Directories may overlap, so that a small file could describe very many.
void require_few(std::uint64_t entries) {
  if (entries > kMostEntries) damaged_picture("its directories have too many entries");
}

}  // namespace

TiffReader::TiffReader(std::string_view content)
    : content_(content), little_(!content.empty() && content[0] == 'I') {
  big_ = number(2, 2) == 43;
}

std::uint64_t TiffReader::first() const { return number(big_ ? 8 : 4, big_ ? 8 : 4); }

std::uint64_t TiffReader::number(std::uint64_t at, int bytes) const {
  if (at > content_.size() || content_.size() - at < static_cast<std::uint64_t>(bytes))
    damaged_picture(fmt::format("it is truncated: it refers to byte {} of {}", at, content_.size()));
  std::uint64_t v = 0;
  for (int k = 0; k < bytes; ++k) {
    const unsigned char byte = content_[at + static_cast<std::uint64_t>(little_ ? bytes - 1 - k : k)];
    v = v << 8 | byte;
  }
  return v;
}

TiffDirectory TiffReader::directory(std::uint64_t at) const {
  const int word = big_ ? 8 : 4;  // bytes per offset and count
  const std::uint64_t entry_size = big_ ? 20 : 12;
  const std::uint64_t n = number(at, big_ ? 8 : 2), first = at + (big_ ? 8 : 2);
  if (n > size() / entry_size)
    damaged_picture(fmt::format("its directory has {} entries, which exceed the file", n));
  TiffDirectory out;
  out.at = at;
  for (std::uint64_t i = 0; i < n; ++i) {
    const std::uint64_t e = first + i * entry_size;
    const std::uint64_t tag = number(e, 2), type = number(e + 2, 2);
    TiffEntry entry{type, width_of(type), number(e + 4, word), e + 4 + word};
    if (entry.count > size()) damaged_picture(fmt::format("its entry {} has {} values", tag, entry.count));
    const std::uint64_t bytes = entry.count * entry.width;
    if (bytes > static_cast<std::uint64_t>(word)) {
      entry.at = number(entry.at, word);
      if (entry.at > size() || bytes > size() - entry.at)
        damaged_picture(fmt::format("it is truncated: its entry {} ends beyond byte {}", tag, size()));
    }
    out.entries[tag] = entry;
  }
  out.next = number(first + n * entry_size, word);
  return out;
}

std::uint64_t TiffReader::value(const TiffEntry& entry, std::uint64_t i) const {
  return number(entry.at + i * entry.width, entry.width);
}

std::uint64_t TiffReader::value(const TiffDirectory& d, std::uint64_t tag, std::uint64_t otherwise) const {
  const auto found = d.entries.find(tag);
  return found == d.entries.end() || found->second.count == 0 || found->second.width == 0
             ? otherwise
             : value(found->second, 0);
}

std::string TiffReader::text(const TiffDirectory& d, std::uint64_t tag) const {
  const auto found = d.entries.find(tag);
  if (found == d.entries.end() || found->second.width != 1) return "";
  const std::string_view all = content_.substr(found->second.at, found->second.count);
  return std::string(all.substr(0, all.find('\0')));
}

double TiffReader::ratio(const TiffDirectory& d, std::uint64_t tag) const {
  const auto found = d.entries.find(tag);
  constexpr std::uint64_t kRational = 5;
  if (found == d.entries.end() || found->second.type != kRational || found->second.count < 1) return 0;
  const double above = number(found->second.at, 4);
  const double below = number(found->second.at + 4, 4);
  return below > 0 ? above / below : 0;
}

std::vector<TiffDirectory> main_directories(const TiffReader& in) {
  std::vector<TiffDirectory> out;
  std::set<std::uint64_t> seen;
  std::uint64_t entries = 0;
  for (std::uint64_t at = in.first(); at != 0 && seen.insert(at).second; at = out.back().next) {
    out.push_back(in.directory(at));
    require_few(entries += 1 + out.back().entries.size());
  }
  return out;
}

std::vector<TiffDirectory> sub_directories(const TiffReader& in, const TiffDirectory& d,
                                           std::set<std::uint64_t>& seen) {
  std::vector<TiffDirectory> out;
  const auto found = d.entries.find(tiff::kSubDirectories);
  if (found == d.entries.end() || found->second.width == 0) return out;
  for (std::uint64_t i = 0; i < found->second.count; ++i)
    if (const auto at = in.value(found->second, i); at != 0 && seen.insert(at).second)
      out.push_back(in.directory(at));
  return out;
}

}  // namespace terrazzo
