// Datasets of HDF5 files: type, size, and elements stored together or in chunks.
#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "nodes/common/io/hdf5/hdf5_errors.h"
#include "nodes/common/io/hdf5/hdf5_layout.h"

namespace terrazzo {
namespace {

constexpr std::uint64_t kMostElements = std::uint64_t{1} << 40;
constexpr unsigned kMostAxes = 8;

}  // namespace

std::uint64_t Hdf5Array::count() const {
  std::uint64_t n = 1;
  for (const std::uint64_t s : size) n *= s;
  return n;
}

// `most`: the sizes up to which the dataset may grow.
void Hdf5Input::read_space(const Message& m, Hdf5Array& out, std::vector<std::uint64_t>* most) const {
  const std::uint64_t version = number(m.at, 1), axes = number(m.at + 1, 1),
                      at = m.at + (version == 1 ? 8 : 4);
  if ((version != 1 && version != 2) || axes > kMostAxes)
    hdf5_damaged("a dataset of the HDF5 file has no valid size");
  if (at + 8 * axes > m.at + m.size) hdf5_damaged("a message of the HDF5 file is too short");
  out.size.clear();
  std::uint64_t count = 1;
  for (std::uint64_t a = 0; a < axes; ++a) {
    const std::uint64_t n = number(at + 8 * a, 8);
    if (n > kMostElements || (n > 0 && count > kMostElements / n))
      hdf5_damaged("a dataset of the HDF5 file is too large");
    count *= n;
    out.size.push_back(n);
  }
  if (!most) return;
  *most = out.size;
  if (!(number(m.at + 2, 1) & 1)) return;
  if (at + 16 * axes > m.at + m.size) hdf5_damaged("a message of the HDF5 file is too short");
  for (std::uint64_t a = 0; a < axes; ++a) (*most)[a] = number(at + 8 * (axes + a), 8);
}

void Hdf5Input::read_type(const Message& m, Hdf5Array& out) const {
  if (m.size < 8) hdf5_damaged("a message of the HDF5 file is too short");
  const std::uint64_t head = number(m.at, 4), type = head & 15, bits = head >> 8;
  out.bytes = number(m.at + 4, 4);
  out.kind = Hdf5Kind::Other;
  if (out.bytes == 0 || out.bytes > content_.size())
    hdf5_damaged("a type of the HDF5 file has an impossible size");
  const bool plain = m.size >= 12 && number(m.at + 8, 2) == 0 && number(m.at + 10, 2) == 8 * out.bytes;
  out.big_endian = type <= 1 && bits & 1;
  if (type == 0 && plain && (out.bytes == 1 || out.bytes == 2 || out.bytes == 4 || out.bytes == 8))
    out.kind = bits & 8 ? Hdf5Kind::Signed : Hdf5Kind::Unsigned;
  // IEEE 754: the exponent begins at bit 23 or 52
  else if (type == 1 && plain && !(bits & 64) && m.size >= 20 &&
           ((out.bytes == 4 && number(m.at + 12, 1) == 23) || (out.bytes == 8 && number(m.at + 12, 1) == 52)))
    out.kind = Hdf5Kind::Float;
  else if (type == 3)
    out.kind = Hdf5Kind::Text;
}

void Hdf5Input::turn_bytes(const Hdf5Array& array, std::string& elements) {
  if (!array.big_endian) return;
  for (std::size_t at = 0; at + array.bytes <= elements.size(); at += array.bytes)
    std::reverse(elements.data() + at, elements.data() + at + array.bytes);
}

void Hdf5Input::read_filters(const Message& m, Layout& out) const {
  const std::uint64_t version = number(m.at, 1), count = number(m.at + 1, 1);
  std::uint64_t at = m.at + (version == 1 ? 8 : 2);
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t id = number(at, 2);
    const bool named = version == 1 || id >= 256;
    const std::uint64_t name = named ? number(at + 2, 2) : 0, values = number(at + (named ? 6 : 4), 2);
    at += (named ? 8 : 6) + (version == 1 ? (name + 7) / 8 * 8 : name) + 4 * values +
          (version == 1 && values % 2 ? 4 : 0);
    if (id < 1 || id > 3)
      hdf5_unsupported("the HDF5 file is compressed by filter " + std::to_string(id) + "; supported is zlib",
                       "write it with zlib, in h5py with compression=\"gzip\"");
    out.filters.push_back(static_cast<unsigned>(id));
  }
}

void Hdf5Input::read_layout(const Message& m, Layout& out) const {
  const std::uint64_t version = number(m.at, 1), kind = number(m.at + 1, 1);
  if (version != 3 && version != 4)
    hdf5_unsupported("the HDF5 file has datasets of version " + std::to_string(version));
  if (kind == 0) {
    out.kind = Layout::Kind::Together;
    out.size = number(m.at + 2, 2);
    out.at = m.at + 4;
  } else if (kind == 1) {
    out.at = number(m.at + 2, 8);
    out.size = number(m.at + 10, 8);
    out.kind = out.at == kNowhere ? Layout::Kind::Missing : Layout::Kind::Together;
  } else if (kind == 2) {
    version == 3 ? read_chunk_layout_3(m, out) : read_chunk_layout_4(m, out);
    out.kind = out.at == kNowhere ? Layout::Kind::Missing : Layout::Kind::Chunks;
  } else {
    hdf5_unsupported("the HDF5 file has a dataset that refers to other files",
                     "copy the data into one file, for example with h5py");
  }
}

void Hdf5Input::read_chunk_layout_3(const Message& m, Layout& out) const {
  const std::uint64_t axes = number(m.at + 2, 1);
  if (axes < 2 || axes > kMostAxes + 1) hdf5_damaged("a dataset of the HDF5 file has no valid chunks");
  out.index = Layout::Index::Tree1;
  out.at = number(m.at + 3, 8);
  for (std::uint64_t a = 0; a + 1 < axes; ++a) out.chunk.push_back(number(m.at + 11 + 4 * a, 4));
}

void Hdf5Input::read_chunk_layout_4(const Message& m, Layout& out) const {
  const std::uint64_t flags = number(m.at + 2, 1), axes = number(m.at + 3, 1), bytes = number(m.at + 4, 1);
  if (axes < 2 || axes > kMostAxes + 1 || bytes < 1 || bytes > 8)
    hdf5_damaged("a dataset of the HDF5 file has no valid chunks");
  for (std::uint64_t a = 0; a + 1 < axes; ++a)
    out.chunk.push_back(number(m.at + 5 + bytes * a, static_cast<unsigned>(bytes)));
  out.whole_at_border = flags & 1;
  std::uint64_t at = m.at + 5 + bytes * axes;
  const std::uint64_t index = number(at++, 1);
  if (index < 1 || index > 5)
    hdf5_unsupported("the HDF5 file has chunks with an index of a kind that is unknown");
  out.index = static_cast<Layout::Index>(index);
  if (out.index == Layout::Index::Single && flags & 2) {
    out.single_stored = number(at, 8);
    out.single_skipped = number(at + 8, 4);
    at += 12;
  } else if (out.index == Layout::Index::FixedArray) {
    at += 1;  // its header repeats the parameters
  } else if (out.index == Layout::Index::ExtensibleArray) {
    at += 5;
  } else if (out.index == Layout::Index::Tree2) {
    at += 6;
  }
  if (at + 8 > m.at + m.size) hdf5_damaged("a message of the HDF5 file is too short");
  out.at = number(at, 8);
}

Hdf5Input::Layout Hdf5Input::layout(Address dataset) const {
  Layout out;
  bool type = false, space = false, stored = false;
  for (const Message& m : messages(dataset)) {
    if (m.type == 0x01) {
      read_space(m, out.array, &out.most);
      space = true;
    } else if (m.type == 0x03) {
      read_type(m, out.array);
      type = true;
    } else if (m.type == 0x0b) {
      read_filters(m, out);
    } else if (m.type == 0x08) {
      read_layout(m, out);
      stored = true;
    }
  }
  if (!type || !space || !stored) hdf5_damaged("a dataset of the HDF5 file is incomplete");
  check_layout(out);
  return out;
}

void Hdf5Input::check_layout(const Layout& out) const {
  if (out.kind == Layout::Kind::Together) require(out.at, out.size);
  if (out.kind != Layout::Kind::Chunks) return;
  std::uint64_t bytes = out.array.bytes;
  if (out.chunk.size() != out.array.size.size())
    hdf5_damaged("a dataset of the HDF5 file has chunks of other axes");
  for (const std::uint64_t n : out.chunk) {
    if (n == 0 || bytes > (std::uint64_t{1} << 32) / n)
      hdf5_damaged("a dataset of the HDF5 file has chunks of an impossible size");
    bytes *= n;
  }
  if (bytes / 2000 > content_.size())
    hdf5_damaged("a dataset of the HDF5 file has chunks that are larger than the file can contain");
}

Hdf5Array Hdf5Input::array(Address dataset) const { return layout(dataset).array; }

std::string Hdf5Input::read(Address dataset) const {
  const Layout l = layout(dataset);
  const std::uint64_t bytes = l.array.count() * l.array.bytes;
  if (l.kind == Layout::Kind::Together) {
    if (l.size < bytes) hdf5_damaged("a dataset of the HDF5 file is shorter than its size");
    std::string out = content_.substr(l.at, bytes);
    turn_bytes(l.array, out);
    return out;
  }
  // The data of a file compressed by zlib are at most 1032 times as long as the file.
  if (bytes / 2000 > content_.size())
    hdf5_damaged("a dataset of the HDF5 file is larger than the file can contain");
  std::string out(bytes, '\0');
  nodes_left_ = content_.size() / 24;
  chunks_left_ = 1;
  for (std::size_t a = 0; a < l.chunk.size(); ++a) chunks_left_ *= l.chunks_along(a);
  if (l.kind != Layout::Kind::Chunks || bytes == 0) return out;
  if (l.index == Layout::Index::Tree1)
    visit_chunks(l.at, 16, l, out);
  else if (l.index == Layout::Index::Tree2)
    visit_tree_2(l, out);
  else
    visit_array(l, out);
  turn_bytes(l.array, out);
  return out;
}

void Hdf5Input::visit_chunks(std::uint64_t node, unsigned deepest, const Layout& l, std::string& out) const {
  if (nodes_left_-- == 0 || deepest == 0)
    hdf5_damaged("a dataset of the HDF5 file has a tree that contains itself");
  require_text(node, "TREE");
  if (number(node + 4, 1) != 1) hdf5_damaged("a dataset of the HDF5 file has a tree of another kind");
  const bool leaf = number(node + 5, 1) == 0;
  const std::uint64_t count = number(node + 6, 2), key = 8 + 8 * (l.chunk.size() + 1);
  for (std::uint64_t k = 0; k < count; ++k) {
    const std::uint64_t at = node + 24 + (key + 8) * k, child = number(at + key, 8);
    if (!leaf) {
      visit_chunks(child, deepest - 1, l, out);
      continue;
    }
    Chunk chunk{{}, child, number(at, 4), number(at + 4, 4)};
    for (std::size_t a = 0; a < l.chunk.size(); ++a) chunk.first.push_back(number(at + 8 + 8 * a, 8));
    place_chunk(chunk, l, out);
  }
}

void Hdf5Input::place_chunk(const Chunk& chunk, const Layout& l, std::string& out) const {
  if (chunks_left_-- == 0) hdf5_damaged("a dataset of the HDF5 file has too many chunks");
  require(chunk.at, chunk.stored);
  const std::uint64_t size = l.chunk_bytes(),
                      skipped = l.keeps_whole(chunk) ? ~std::uint64_t{0} : chunk.skipped;
  std::string bytes = content_.substr(chunk.at, chunk.stored);
  for (std::size_t f = l.filters.size(); f-- > 0;) {
    if (skipped >> f & 1) continue;
    if (l.filters[f] == 3) {  // Fletcher's checksum
      bytes.resize(bytes.size() < 4 ? 0 : bytes.size() - 4);
    } else if (l.filters[f] == 2) {  // first bytes of all elements, then their second ones, …
      const std::size_t step = l.array.bytes, n = bytes.size() / step;
      std::string plain = bytes;
      for (std::size_t b = 0; b < step; ++b)
        for (std::size_t i = 0; i < n; ++i) plain[i * step + b] = bytes[b * n + i];
      bytes = std::move(plain);
    } else {
      std::string plain(size + 16, '\0');
      uLongf length = plain.size();
      if (uncompress(reinterpret_cast<Bytef*>(plain.data()), &length,
                     reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != Z_OK)
        hdf5_damaged("compressed data of the HDF5 file are damaged");
      plain.resize(length);
      bytes = std::move(plain);
    }
  }
  if (bytes.size() < size) hdf5_damaged("a chunk of the HDF5 file is too short");
  // Rows of the last axis, cut at the border of the array.
  const std::size_t axes = l.chunk.size();
  const std::vector<std::uint64_t>& first = chunk.first;
  std::vector<std::uint64_t> at(axes, 0);
  for (std::size_t a = 0; a < axes; ++a)
    if (first[a] >= l.array.size[a]) hdf5_damaged("a chunk of the HDF5 file is outside its dataset");
  const std::uint64_t row =
      std::min(l.chunk[axes - 1], l.array.size[axes - 1] - first[axes - 1]) * l.array.bytes;
  for (std::uint64_t from = 0; from < size;) {
    bool inside = true;
    std::uint64_t to = 0;
    for (std::size_t a = 0; a < axes; ++a) {
      inside = inside && first[a] + at[a] < l.array.size[a];
      to = to * l.array.size[a] + first[a] + at[a];
    }
    if (inside) std::memcpy(out.data() + to * l.array.bytes, bytes.data() + from, row);
    from += l.chunk[axes - 1] * l.array.bytes;
    for (std::size_t a = axes - 1; a-- > 0;) {
      if (++at[a] < l.chunk[a]) break;
      at[a] = 0;
    }
  }
}

}  // namespace terrazzo
