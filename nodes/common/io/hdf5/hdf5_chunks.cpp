// The indexes by which newer HDF5 files find the chunks of a dataset.
#include <bit>

#include "nodes/common/io/hdf5/hdf5_errors.h"
#include "nodes/common/io/hdf5/hdf5_layout.h"

namespace terrazzo {
namespace {

std::uint64_t power(std::uint64_t exponent) { return std::uint64_t{1} << exponent; }

// The number of a chunk in an array of all chunks that the dataset may have. An axis that may grow without
// end counts as the first.
class ChunkOrder {
 public:
  ChunkOrder(const std::vector<std::uint64_t>& most, const std::vector<std::uint64_t>& chunk,
             bool extensible) {
    for (std::size_t a = 0; a < most.size(); ++a) axes_.push_back(a);
    for (std::size_t a = 0; extensible && a < most.size(); ++a)
      if (most[a] == kNowhere) {
        axes_.erase(axes_.begin() + a);
        axes_.insert(axes_.begin(), a);
        break;
      }
    below_.assign(axes_.size(), 1);
    for (std::size_t k = axes_.size(); k-- > 1;) {
      const std::uint64_t along = most[axes_[k]] / chunk[axes_[k]] + (most[axes_[k]] % chunk[axes_[k]] != 0);
      if (along == 0 || below_[k] > power(56) / along)
        hdf5_damaged("a dataset of the HDF5 file may grow beyond what is possible");
      below_[k - 1] = below_[k] * along;
    }
  }
  std::uint64_t number_of(const std::vector<std::uint64_t>& scaled) const {
    std::uint64_t n = 0;
    for (std::size_t k = 0; k < axes_.size(); ++k) n += scaled[axes_[k]] * below_[k];
    return n;
  }

 private:
  std::vector<std::size_t> axes_;  // slowest first
  std::vector<std::uint64_t> below_;
};

// An element of a block whose elements follow each other, in pages with a checksum each if there are many.
std::uint64_t element_in(std::uint64_t elements_at, std::uint64_t page, std::uint64_t count,
                         std::uint64_t size, std::uint64_t index) {
  return count <= page ? elements_at + index * size
                       : elements_at + index / page * (page * size + 4) + index % page * size;
}

}  // namespace

bool Hdf5Input::bit_at(std::uint64_t bitmap, std::uint64_t bit) const {
  return number(bitmap + bit / 8, 1) >> (7 - bit % 8) & 1;
}

std::uint64_t Hdf5Input::fixed_array_entry(const Layout& l, std::uint64_t index) const {
  require_text(l.at, "FAHD");
  const std::uint64_t size = number(l.at + 6, 1), bits = number(l.at + 7, 1), count = number(l.at + 8, 8),
                      block = number(l.at + 16, 8);
  if (block == kNowhere) return kNowhere;
  if (index >= count || bits > 40) hdf5_damaged("an index of chunks of the HDF5 file is too short");
  require_text(block, "FADB");
  std::uint64_t at = block + 14;
  if (count > power(bits)) {
    const std::uint64_t page = index >> bits;
    if (!bit_at(at, page)) return kNowhere;  // never written
    const std::uint64_t pages = (count - 1) / power(bits) + 1;
    at += (pages + 7) / 8 + 4;
  }
  return element_in(at, power(bits), count, size, index);
}

std::uint64_t Hdf5Input::extensible_array_entry(const Layout& l, std::uint64_t index) const {
  require_text(l.at, "EAHD");
  const std::uint64_t size = number(l.at + 6, 1), most_bits = number(l.at + 7, 1),
                      in_index = number(l.at + 8, 1), least = number(l.at + 9, 1),
                      pointers = number(l.at + 10, 1), page_bits = number(l.at + 11, 1),
                      top = number(l.at + 60, 8);
  if (top == kNowhere) return kNowhere;
  if (most_bits > 64 || page_bits > 32 || !std::has_single_bit(least) || !std::has_single_bit(pointers))
    hdf5_damaged("an index of chunks of the HDF5 file has impossible parameters");
  require_text(top, "EAIB");
  const std::uint64_t elements = top + 14;
  if (index < in_index) return elements + index * size;
  index -= in_index;
  // Block n of the second level has 2^(n/2) blocks of 2^((n+1)/2) · least elements.
  const auto n = static_cast<std::uint64_t>(std::bit_width(index / least + 1)) - 1;
  if (n > 60) hdf5_damaged("an index of chunks of the HDF5 file is too long");
  const std::uint64_t in_block = power((n + 1) / 2) * least, rest = index - (power(n) - 1) * least,
                      offset_bytes = (most_bits + 7) / 8;
  const std::uint64_t direct = 2 * (static_cast<std::uint64_t>(std::bit_width(pointers)) - 1);
  const std::uint64_t blocks_at = elements + in_index * size;
  std::uint64_t block = 0;
  bool written = true;
  if (n < direct) {
    std::uint64_t before = 0;
    for (std::uint64_t k = 0; k < n; ++k) before += power(k / 2);
    block = number(blocks_at + 8 * (before + rest / in_block), 8);
  } else {
    const std::uint64_t second = number(blocks_at + 8 * (2 * (pointers - 1) + n - direct), 8);
    if (second == kNowhere) return kNowhere;
    require_text(second, "EASB");
    const std::uint64_t bitmap = second + 14 + offset_bytes,
                        pages = in_block > power(page_bits) ? in_block >> page_bits : 0,
                        bitmap_bytes = (pages + 7) / 8;
    if (pages > 0) {
      const std::uint64_t page = rest / in_block * pages + (rest % in_block >> page_bits);
      written = bit_at(bitmap, page);
    }
    block = number(bitmap + power(n / 2) * bitmap_bytes + 8 * (rest / in_block), 8);
  }
  if (block == kNowhere || !written) return kNowhere;
  require_text(block, "EADB");
  const std::uint64_t first = block + 14 + offset_bytes + (in_block > power(page_bits) ? 4 : 0);
  return element_in(first, power(page_bits), in_block, size, rest % in_block);
}

void Hdf5Input::visit_array(const Layout& l, std::string& out) const {
  const std::size_t axes = l.chunk.size();
  const bool extensible = l.index == Layout::Index::ExtensibleArray, filtered = !l.filters.empty();
  const ChunkOrder order(l.most, l.chunk, extensible);
  const std::uint64_t plain = l.chunk_bytes(), count = chunks_left_;
  if (count > content_.size()) hdf5_damaged("a dataset of the HDF5 file has more chunks than it can contain");
  std::vector<std::uint64_t> scaled(axes, 0);
  for (std::uint64_t c = 0; c < count; ++c) {
    Chunk chunk{{}, l.at, plain, 0};
    for (std::size_t a = 0; a < axes; ++a) chunk.first.push_back(scaled[a] * l.chunk[a]);
    if (l.index == Layout::Index::Single) {
      if (l.single_stored > 0) {
        chunk.stored = l.single_stored;
        chunk.skipped = l.single_skipped;
      }
    } else if (l.index == Layout::Index::Implicit) {
      chunk.at += order.number_of(scaled) * plain;
    } else {
      const std::uint64_t n = order.number_of(scaled),
                          entry = extensible ? extensible_array_entry(l, n) : fixed_array_entry(l, n),
                          size = number(l.at + 6, 1);
      chunk.at = entry == kNowhere ? kNowhere : number(entry, 8);
      if (chunk.at != kNowhere && filtered) {
        if (size < 13 || size > 20)
          hdf5_damaged("an index of chunks of the HDF5 file has impossible entries");
        chunk.stored = number(entry + 8, size - 12);
        chunk.skipped = number(entry + size - 4, 4);
      }
    }
    if (chunk.at != kNowhere) place_chunk(chunk, l, out);
    for (std::size_t a = axes; a-- > 0;) {
      if (++scaled[a] < l.chunks_along(a)) break;
      scaled[a] = 0;
    }
  }
}

void Hdf5Input::visit_tree_2(const Layout& l, std::string& out) const {
  const Records all = records(l.at);
  const std::uint64_t axes = l.chunk.size(), places = 8 * axes, type = number(l.at + 5, 1);
  if ((type != 10 && type != 11) || all.size < 8 + places + (type == 11 ? 5 : 0) || all.size > 20 + places)
    hdf5_damaged("a dataset of the HDF5 file has a tree of another kind");
  for (const std::uint64_t record : all.at) {
    Chunk chunk{{}, number(record, 8), l.chunk_bytes(), 0};
    const std::uint64_t scaled = record + all.size - places;
    if (type == 11) {
      chunk.stored = number(record + 8, all.size - places - 12);
      chunk.skipped = number(scaled - 4, 4);
    }
    for (std::uint64_t a = 0; a < axes; ++a) {
      const std::uint64_t n = number(scaled + 8 * a, 8);
      if (n > l.array.size[a]) hdf5_damaged("a chunk of the HDF5 file is outside its dataset");
      chunk.first.push_back(n * l.chunk[a]);
    }
    if (chunk.at != kNowhere) place_chunk(chunk, l, out);
  }
}

}  // namespace terrazzo
