// Fractal heaps and trees of version 2 of HDF5 files, which hold the links and attributes of large groups.
#include <algorithm>
#include <bit>

#include "nodes/common/io/hdf5/hdf5_errors.h"
#include "nodes/common/io/hdf5/hdf5_input.h"

namespace terrazzo {
namespace {

// Bytes that a number up to `most` takes.
unsigned bytes_for(std::uint64_t most) {
  return most == 0 ? 1 : static_cast<unsigned>((std::bit_width(most) + 7) / 8);
}

bool is_power_of_two(std::uint64_t v) { return std::has_single_bit(v); }

}  // namespace

// The blocks of a heap are rows of a table. The first two rows have blocks of one size, each other row of
// twice the size of the row before. Rows of large blocks have tables themselves.
struct Hdf5Input::HeapTable {
  std::uint64_t width = 0, smallest = 0, largest_direct = 0, root = 0, rows = 0;
  unsigned offset_bytes = 0, length_bytes = 0;
  std::uint64_t id_bytes = 0;

  std::uint64_t block(std::uint64_t row) const { return row < 2 ? smallest : smallest << (row - 1); }
  // The rows of the table of a block in that row; 0 if the block holds objects.
  std::uint64_t rows_below(std::uint64_t row) const {
    return block(row) <= largest_direct
               ? 0
               : static_cast<std::uint64_t>(std::bit_width(block(row) / (smallest * width)));
  }
};

Hdf5Input::Records Hdf5Input::records(Address tree) const {
  require_text(tree, "BTHD");
  Records out;
  const std::uint64_t node_size = number(tree + 6, 4), depth = number(tree + 12, 2);
  out.size = number(tree + 10, 2);
  if (out.size == 0 || node_size < 10 + out.size || depth > 16)
    hdf5_damaged("a tree of the HDF5 file has nodes of an impossible size");
  // What a child's entry in a node of each depth takes.
  const std::uint64_t leaf_records = (node_size - 10) / out.size;
  const unsigned count_bytes = bytes_for(leaf_records);
  std::vector<unsigned> total_bytes = {0};
  std::uint64_t total = leaf_records;
  for (std::uint64_t d = 1; d < depth; ++d) {
    const std::uint64_t entry = 8 + count_bytes + total_bytes.back();
    if (node_size < 10 + entry) hdf5_damaged("a tree of the HDF5 file has nodes of an impossible size");
    const std::uint64_t most = (node_size - 10 - entry) / (out.size + entry);
    if (most >= 0xffffffff || total > (std::uint64_t{1} << 56) / (most + 1))
      hdf5_damaged("a tree of the HDF5 file is too deep");
    total = (most + 1) * total + most;
    total_bytes.push_back(bytes_for(total));
  }
  struct Node {
    std::uint64_t at, count, depth;
  };
  std::vector<Node> nodes = {{number(tree + 16, 8), number(tree + 24, 2), depth}};
  if (number(tree + 26, 8) == 0) return out;
  std::uint64_t seen = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Node node = nodes[n];
    require_text(node.at, node.depth == 0 ? "BTLF" : "BTIN");
    require(node.at + 6, node.count * out.size);
    if ((seen += 6 + node.count * out.size) > content_.size())
      hdf5_damaged("a tree of the HDF5 file contains itself");
    for (std::uint64_t k = 0; k < node.count; ++k) out.at.push_back(node.at + 6 + k * out.size);
    if (node.depth == 0) continue;
    const std::uint64_t entry = 8 + count_bytes + total_bytes[node.depth - 1];
    for (std::uint64_t k = 0; k <= node.count; ++k) {
      const std::uint64_t at = node.at + 6 + node.count * out.size + k * entry;
      nodes.push_back({number(at, 8), number(at + 8, count_bytes), node.depth - 1});
    }
  }
  return out;
}

Hdf5Input::HeapTable Hdf5Input::heap_table(Address heap) const {
  require_text(heap, "FRHP");
  if (number(heap + 7, 2) != 0) hdf5_unsupported("the HDF5 file has groups whose names are compressed");
  HeapTable table;
  const std::uint64_t bits = number(heap + 128, 2);
  table.id_bytes = number(heap + 5, 2);
  table.width = number(heap + 110, 2);
  table.smallest = number(heap + 112, 8);
  table.largest_direct = number(heap + 120, 8);
  table.root = number(heap + 132, 8);
  table.rows = number(heap + 140, 2);
  if (!is_power_of_two(table.width) || !is_power_of_two(table.smallest) ||
      !is_power_of_two(table.largest_direct) || table.largest_direct < table.smallest || bits > 64 ||
      std::bit_width(table.width) + std::bit_width(table.smallest) + static_cast<int>(table.rows) > 60)
    hdf5_damaged("a heap of the HDF5 file has blocks of an impossible size");
  table.offset_bytes = (bits + 7) / 8;
  table.length_bytes = std::min(bytes_for(table.largest_direct - 1), bytes_for(number(heap + 10, 4)));
  if (1 + table.offset_bytes + table.length_bytes > table.id_bytes)
    hdf5_damaged("a heap of the HDF5 file has names of an impossible size");
  return table;
}

// Goes down from the root to the block that contains the offset.
std::uint64_t Hdf5Input::heap_place(const HeapTable& table, std::uint64_t offset) const {
  std::uint64_t at = table.root, rows = table.rows, begin = 0;
  while (rows > 0) {
    require_text(at, "FHIB");
    std::uint64_t row = 0, first = begin;
    while (row < rows && offset - first >= table.width * table.block(row)) {
      first += table.width * table.block(row);
      ++row;
    }
    if (row == rows) hdf5_damaged("a heap of the HDF5 file has no block where one should be");
    const std::uint64_t column = (offset - first) / table.block(row);
    at = number(at + 13 + table.offset_bytes + 8 * (row * table.width + column), 8);
    begin = first + column * table.block(row);
    const std::uint64_t below = table.rows_below(row);
    if (below >= rows) hdf5_damaged("a heap of the HDF5 file contains itself");
    rows = below;
  }
  require_text(at, "FHDB");
  require(at, offset - begin);
  return at + (offset - begin);
}

std::vector<Hdf5Input::Message> Hdf5Input::heap_objects(Address heap, Address tree, unsigned type) const {
  const HeapTable table = heap_table(heap);
  require_text(tree, "BTHD");
  if (number(tree + 5, 1) != type) hdf5_damaged("a group of the HDF5 file has a tree of another kind");
  const Records all = records(tree);
  const std::uint64_t id_at = type == 5 ? 4 : 0;  // a link's record begins with the hash of its name
  if (id_at + table.id_bytes > all.size)
    hdf5_damaged("a tree of the HDF5 file has records of an impossible size");
  std::vector<Message> out;
  for (const std::uint64_t record : all.at) {
    const std::uint64_t id = record + id_at;
    if ((number(id, 1) & 0x30) != 0)
      hdf5_unsupported("the HDF5 file stores links or attributes outside their group's heap");
    const std::uint64_t offset = number(id + 1, table.offset_bytes),
                        length = number(id + 1 + table.offset_bytes, table.length_bytes),
                        place = heap_place(table, offset);
    require(place, length);
    out.push_back({type == 5 ? 0x06u : 0x0cu, place, length});
  }
  return out;
}

}  // namespace terrazzo
