#include "tests/support/tiff_file.h"

#include <algorithm>

namespace terrazzo::test {
namespace {

class TiffWriter {
 public:
  explicit TiffWriter(const TiffKind& kind) : kind_(kind) {
    bytes_ = kind.big_endian ? "MM" : "II";
    if (kind.wide) {
      put(43, 2);
      put(8, 2);
      put(0, 2);
      link_ = bytes_.size();
      put(0, 8);
    } else {
      put(42, 2);
      link_ = bytes_.size();
      put(0, 4);
    }
  }

  void page(const TiffPage& p) {
    std::size_t next = 0;
    overwrite(link_, directory(p, next));
    link_ = next;
  }
  std::string bytes_;

 private:
  std::string number(std::uint64_t v, int size) const {
    std::string out;
    for (int k = 0; k < size; ++k) out += static_cast<char>(v >> (8 * (kind_.big_endian ? size - 1 - k : k)));
    return out;
  }
  void put(std::uint64_t v, int size) { bytes_ += number(v, size); }
  void overwrite(std::size_t at, std::uint64_t v) {
    const int word = kind_.wide ? 8 : 4;
    bytes_.replace(at, static_cast<std::size_t>(word), number(v, word));
  }

  struct Entry {
    int tag, type;
    std::uint64_t count;
    std::string data;
  };
  Entry whole(int tag, const std::vector<std::uint32_t>& values, bool as_long) const {
    Entry e{tag, as_long ? 4 : 3, values.size(), {}};
    for (const auto v : values) e.data += number(v, as_long ? 4 : 2);
    return e;
  }

  // Appends pixels and a directory, and returns where it is. `next`: where the link to the next one is.
  std::uint64_t directory(const TiffPage& p, std::size_t& next) {
    std::vector<std::uint32_t> subs;
    for (const auto& sub : p.sub_pages) {
      std::size_t none = 0;
      subs.push_back(static_cast<std::uint32_t>(directory(sub, none)));
    }
    const auto pixels = static_cast<std::uint32_t>(bytes_.size());
    bytes_ += p.pixels;
    if (bytes_.size() % 2) bytes_ += '\0';
    const auto length = static_cast<std::uint32_t>(p.pixels.size());
    std::vector<Entry> entries = {whole(256, {static_cast<std::uint32_t>(p.width)}, true),
                                  whole(257, {static_cast<std::uint32_t>(p.height)}, true),
                                  whole(258,
                                        std::vector<std::uint32_t>(static_cast<std::size_t>(p.samples),
                                                                   static_cast<std::uint32_t>(p.bits)),
                                        false),
                                  whole(259, {1}, false),
                                  whole(262, {static_cast<std::uint32_t>(p.photometric)}, false),
                                  whole(273, {pixels}, true),
                                  whole(277, {static_cast<std::uint32_t>(p.samples)}, false),
                                  whole(278, {static_cast<std::uint32_t>(p.height)}, true),
                                  whole(279, {length}, true),
                                  whole(339, {static_cast<std::uint32_t>(p.format)}, false)};
    if (!p.description.empty()) entries.push_back({270, 2, p.description.size() + 1, p.description + '\0'});
    if (!subs.empty()) entries.push_back(whole(330, subs, true));
    for (const auto& [tag, values] : p.tags) {
      std::erase_if(entries, [&, &t = tag](const Entry& e) { return e.tag == t; });
      entries.push_back(whole(tag, values, *std::max_element(values.begin(), values.end()) > 65535));
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
    return write(entries, next);
  }

  std::uint64_t write(std::vector<Entry>& entries, std::size_t& next) {
    const std::size_t word = kind_.wide ? 8 : 4;
    for (auto& e : entries)
      if (e.data.size() > word) {
        const std::size_t at = bytes_.size();
        bytes_ += e.data;
        if (bytes_.size() % 2) bytes_ += '\0';
        e.data = number(at, static_cast<int>(word));
      } else {
        e.data.resize(word, '\0');
      }
    const std::uint64_t at = bytes_.size();
    put(entries.size(), kind_.wide ? 8 : 2);
    for (const auto& e : entries) {
      put(static_cast<std::uint64_t>(e.tag), 2);
      put(static_cast<std::uint64_t>(e.type), 2);
      put(e.count, static_cast<int>(word));
      bytes_ += e.data;
    }
    next = bytes_.size();
    put(0, static_cast<int>(word));
    return at;
  }

  TiffKind kind_;
  std::size_t link_ = 0;
};

}  // namespace

std::string tiff_file(const std::vector<TiffPage>& pages, const TiffKind& kind) {
  TiffWriter writer(kind);
  for (const auto& p : pages) writer.page(p);
  return writer.bytes_;
}

}  // namespace terrazzo::test
