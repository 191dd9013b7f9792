// Datasets of HDF5 files: type, size, and elements stored together or in chunks.
#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "nodes/common/io/hdf5_errors.h"
#include "nodes/common/io/hdf5_input.h"

namespace terrazzo {
namespace {

constexpr std::uint64_t kNowhere = ~std::uint64_t{0};
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 40;
constexpr unsigned kMostAxes = 8;

}  // namespace

std::uint64_t Hdf5Array::count() const {
  std::uint64_t n = 1;
  for (const std::uint64_t s : size) n *= s;
  return n;
}

struct Hdf5Input::Layout {
  Hdf5Array array;
  enum class Kind { Missing, Together, Chunks } kind = Kind::Missing;
  std::uint64_t at = kNowhere, size = 0;  // data, or the tree of chunks
  std::vector<std::uint64_t> chunk;       // elements along each axis
  std::vector<unsigned> filters;          // in the order of writing
};

void Hdf5Input::read_space(const Message& m, Hdf5Array& out) const {
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
}

void Hdf5Input::read_type(const Message& m, Hdf5Array& out) const {
  if (m.size < 8) hdf5_damaged("a message of the HDF5 file is too short");
  const std::uint64_t head = number(m.at, 4), type = head & 15, bits = head >> 8;
  out.bytes = number(m.at + 4, 4);
  out.kind = Hdf5Kind::Other;
  if (out.bytes == 0 || out.bytes > content_.size())
    hdf5_damaged("a type of the HDF5 file has an impossible size");
  const bool little = (bits & 1) == 0;
  const bool plain =
      m.size >= 12 && little && number(m.at + 8, 2) == 0 && number(m.at + 10, 2) == 8 * out.bytes;
  if (type == 0 && plain && (out.bytes == 1 || out.bytes == 2 || out.bytes == 4 || out.bytes == 8))
    out.kind = bits & 8 ? Hdf5Kind::Signed : Hdf5Kind::Unsigned;
  // IEEE 754: the exponent begins at bit 23 or 52
  else if (type == 1 && plain && !(bits & 64) && m.size >= 20 &&
           ((out.bytes == 4 && number(m.at + 12, 1) == 23) || (out.bytes == 8 && number(m.at + 12, 1) == 52)))
    out.kind = Hdf5Kind::Float;
  else if (type == 3)
    out.kind = Hdf5Kind::Text;
}

Hdf5Input::Layout Hdf5Input::layout(Address dataset) const {
  Layout out;
  bool type = false, space = false, stored = false;
  for (const Message& m : messages(dataset)) {
    if (m.type == 0x01) read_space(m, out.array), space = true;
    if (m.type == 0x03) read_type(m, out.array), type = true;
    if (m.type == 0x0b) {
      const std::uint64_t version = number(m.at, 1), count = number(m.at + 1, 1);
      std::uint64_t at = m.at + (version == 1 ? 8 : 2);
      for (std::uint64_t k = 0; k < count; ++k) {
        const std::uint64_t id = number(at, 2);
        const bool named = version == 1 || id >= 256;
        const std::uint64_t name = named ? number(at + 2, 2) : 0, values = number(at + (named ? 6 : 4), 2);
        at += (named ? 8 : 6) + (version == 1 ? (name + 7) / 8 * 8 : name) + 4 * values +
              (version == 1 && values % 2 ? 4 : 0);
        if (id < 1 || id > 3)
          hdf5_unsupported("the HDF5 file is compressed by filter " + std::to_string(id) +
                           "; supported is zlib");
        out.filters.push_back(static_cast<unsigned>(id));
      }
    }
    if (m.type != 0x08) continue;
    if (number(m.at, 1) != 3)
      hdf5_unsupported("the HDF5 file has datasets of version " + std::to_string(number(m.at, 1)));
    stored = true;
    const std::uint64_t kind = number(m.at + 1, 1);
    if (kind == 0) {
      out.kind = Layout::Kind::Together, out.size = number(m.at + 2, 2), out.at = m.at + 4;
    } else if (kind == 1) {
      out.at = number(m.at + 2, 8), out.size = number(m.at + 10, 8);
      out.kind = out.at == kNowhere ? Layout::Kind::Missing : Layout::Kind::Together;
    } else if (kind == 2) {
      const std::uint64_t axes = number(m.at + 2, 1);
      if (axes < 2 || axes > kMostAxes + 1) hdf5_damaged("a dataset of the HDF5 file has no valid chunks");
      out.at = number(m.at + 3, 8);
      out.kind = out.at == kNowhere ? Layout::Kind::Missing : Layout::Kind::Chunks;
      for (std::uint64_t a = 0; a + 1 < axes; ++a) out.chunk.push_back(number(m.at + 11 + 4 * a, 4));
    } else {
      hdf5_unsupported("the HDF5 file has a dataset of an unknown form");
    }
  }
  if (!type || !space || !stored) hdf5_damaged("a dataset of the HDF5 file is incomplete");
  if (out.kind == Layout::Kind::Together) require(out.at, out.size);
  if (out.kind == Layout::Kind::Chunks) {
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
  return out;
}

Hdf5Array Hdf5Input::array(Address dataset) const { return layout(dataset).array; }

std::string Hdf5Input::read(Address dataset) const {
  const Layout l = layout(dataset);
  const std::uint64_t bytes = l.array.count() * l.array.bytes;
  if (l.kind == Layout::Kind::Together) {
    if (l.size < bytes) hdf5_damaged("a dataset of the HDF5 file is shorter than its size");
    return content_.substr(l.at, bytes);
  }
  // The data of a file compressed by zlib are at most 1032 times as long as the file.
  if (bytes / 2000 > content_.size())
    hdf5_damaged("a dataset of the HDF5 file is larger than the file can contain");
  std::string out(bytes, '\0');
  nodes_left_ = content_.size() / 24, chunks_left_ = 1;
  for (std::size_t a = 0; a < l.chunk.size(); ++a)
    chunks_left_ *= (l.array.size[a] + l.chunk[a] - 1) / l.chunk[a];
  if (l.kind == Layout::Kind::Chunks && bytes > 0) visit_chunks(l.at, 16, l, out);
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
    if (leaf)
      place_chunk(at, child, l, out);
    else
      visit_chunks(child, deepest - 1, l, out);
  }
}

void Hdf5Input::place_chunk(std::uint64_t key, std::uint64_t data, const Layout& l, std::string& out) const {
  if (chunks_left_-- == 0) hdf5_damaged("a dataset of the HDF5 file has too many chunks");
  const std::uint64_t stored = number(key, 4), skipped = number(key + 4, 4);
  require(data, stored);
  std::uint64_t size = l.array.bytes;
  for (const std::uint64_t n : l.chunk) size *= n;
  std::string bytes = content_.substr(data, stored);
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
  std::vector<std::uint64_t> first(axes), at(axes, 0);
  for (std::size_t a = 0; a < axes; ++a) {
    first[a] = number(key + 8 + 8 * a, 8);
    if (first[a] >= l.array.size[a]) hdf5_damaged("a chunk of the HDF5 file is outside its dataset");
  }
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
