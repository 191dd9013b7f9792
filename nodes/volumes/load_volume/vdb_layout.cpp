#include "nodes/volumes/load_volume/vdb_layout.h"

#include <fmt/format.h>
#include <openvdb/io/Compression.h>

#include <bit>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/grids.h"

namespace terrazzo::load_volume {
namespace {

Error damaged(const std::string& what) {
  return Error("unreadable-volume", what, "check that the file is complete");
}

// Validates one tree. All supported grids share its layout: a root, two levels of inner nodes, leaves of 8³
// voxels.
template <class Tree>
class TreeWalk {
  using Upper = typename Tree::RootNodeType::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  using Leaf = typename Tree::LeafNodeType;
  using T = typename Tree::ValueType;
  static constexpr bool kBool = std::is_same_v<T, bool>;

 public:
  TreeWalk(ByteCursor& in, const VdbGrid& grid) : in_(in), compression_(grid.compression), half_(grid.half) {}

  // Advances to the end of the tree. Returns the memory the tree will need.
  double run() {
    if (in_.take<std::uint32_t>() != 1) throw damaged("a tree has more than one buffer");
    in_.take(sizeof(T));
    const auto tiles = in_.take<std::uint32_t>(), children = in_.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < tiles; ++i) {
      take_origin();
      in_.take(sizeof(T));
      require_flag(in_.take<std::uint8_t>());
      memory_ += 100;  // an entry of the root's map
    }
    for (std::uint32_t i = 0; i < children; ++i) {
      take_origin();
      upper();
    }
    for (std::uint64_t i = 0; i < leaves_; ++i) leaf_values();
    return memory_;
  }

 private:
  static void require_flag(std::uint8_t v) {
    if (v > 1) throw damaged(fmt::format("a boolean is {}", v));
  }

  void take_origin() {
    const auto p = in_.take<std::array<std::int32_t, 3>>();
    for (const auto v : p)
      if (v % static_cast<std::int32_t>(Upper::DIM) != 0)
        throw damaged(fmt::format("a node has the invalid origin ({}, {}, {})", p[0], p[1], p[2]));
    if (!origins_.insert(p).second)
      throw damaged(fmt::format("two nodes have the origin ({}, {}, {})", p[0], p[1], p[2]));
  }

  static std::size_t bits_of(std::string_view mask) {
    std::size_t n = 0;
    for (const char c : mask) n += std::popcount(static_cast<unsigned char>(c));
    return n;
  }

  void upper() {
    const auto children = node<Upper>();
    for (std::size_t i = 0; i < children; ++i) {
      const auto leaves = node<Lower>();
      for (std::size_t k = 0; k < leaves; ++k) {
        in_.take(Leaf::SIZE / 8);
        memory_ += sizeof(Leaf) + Leaf::SIZE * sizeof(T) + 64;
      }
      leaves_ += leaves;
    }
  }

  // Reads the masks and values of an inner node. Returns the number of its children.
  template <class Node>
  std::size_t node() {
    const std::string_view children = in_.take(Node::NUM_VALUES / 8), active = in_.take(Node::NUM_VALUES / 8);
    for (std::size_t i = 0; i < children.size(); ++i)
      if (children[i] & active[i]) throw damaged("a node is both a child and a value");
    values(Node::NUM_VALUES, active);
    memory_ += sizeof(Node);
    return bits_of(children);
  }

  void leaf_values() {
    const std::string_view active = in_.take(Leaf::SIZE / 8);
    if constexpr (kBool)
      in_.take(12 + Leaf::SIZE / 8);  // an origin, and the values as a mask
    else
      values(Leaf::SIZE, active);
  }

  // Mirrors io::readCompressedValues.
  void values(std::size_t count, std::string_view active) {
    using namespace openvdb::io;
    const auto kind = in_.take<std::int8_t>();
    if (kind < NO_MASK_OR_INACTIVE_VALS || kind > NO_MASK_AND_ALL_VALS)
      throw damaged(fmt::format("the value encoding {} is unknown", kind));
    if (kind == NO_MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_ONE_INACTIVE_VAL) in_.take(sizeof(T));
    if (kind == MASK_AND_TWO_INACTIVE_VALS) in_.take(2 * sizeof(T));
    if (kind == MASK_AND_NO_INACTIVE_VALS || kind == MASK_AND_ONE_INACTIVE_VAL ||
        kind == MASK_AND_TWO_INACTIVE_VALS)
      in_.take(count / 8);
    if ((compression_ & COMPRESS_ACTIVE_MASK) && kind != NO_MASK_AND_ALL_VALS) count = bits_of(active);
    using Half = RealToHalf<T>;
    if (half_ && Half::isReal && count < 1) return;
    block(count * (half_ && Half::isReal ? sizeof(typename Half::HalfT) : sizeof(T)));
  }

  // A block of bytes, compressed or not. Blosc's own header is checked too, since its decoder trusts it.
  void block(std::size_t bytes) {
    using namespace openvdb::io;
    if (!(compression_ & (COMPRESS_BLOSC | COMPRESS_ZIP))) {
      in_.take(bytes);
      return;
    }
    const auto stored = in_.take<std::int64_t>();
    if (stored <= 0) {
      if (stored != -static_cast<std::int64_t>(bytes))
        throw damaged(fmt::format("a block has {} bytes instead of {}", -(stored + 1), bytes));
      in_.take(bytes);
      return;
    }
    ByteCursor packed(in_.take(static_cast<std::uint64_t>(stored)));
    if (!(compression_ & COMPRESS_BLOSC)) return;
    packed.take(4);
    const auto unpacked = packed.take<std::uint32_t>();
    packed.take(4);
    const auto size = packed.take<std::uint32_t>();
    if (unpacked != bytes || size != static_cast<std::uint64_t>(stored))
      throw damaged(fmt::format("a compressed block of {} bytes contains {} bytes instead of {}", stored,
                                unpacked, bytes));
  }

  ByteCursor& in_;
  std::uint32_t compression_;
  bool half_;
  double memory_ = 0;
  std::uint64_t leaves_ = 0;
  std::set<std::array<std::int32_t, 3>> origins_;
};

// Size of a linear transform of the given type in doubles; 0 for other types.
std::size_t doubles_of(std::string_view transform) {
  using namespace openvdb::math;
  const auto is = [&](const openvdb::Name& name) { return transform == name; };
  if (is(AffineMap::mapType()) || is(UnitaryMap::mapType())) return 16;
  if (is(ScaleMap::mapType()) || is(UniformScaleMap::mapType())) return 15;
  if (is(ScaleTranslateMap::mapType()) || is(UniformScaleTranslateMap::mapType())) return 18;
  if (is(TranslationMap::mapType())) return 3;
  return 0;
}

template <class... Grids>
bool walk_one_of(ByteCursor& in, VdbGrid& grid) {
  return ((grid.type == Grids::gridType() &&
           (grid.memory = TreeWalk<typename Grids::TreeType>(in, grid).run(), true)) ||
          ...);
}

// Reads everything after a grid's descriptor.
void read_grid(ByteCursor& in, VdbGrid& grid) {
  using namespace openvdb;
  for (const auto& type : {FloatGrid::gridType(), DoubleGrid::gridType(), Vec3SGrid::gridType(),
                           Int32Grid::gridType(), BoolGrid::gridType(), Vec3IGrid::gridType()})
    grid.known = grid.known || type == grid.type;
  if (!grid.known) return;
  grid.compression = in.take<std::uint32_t>();
  grid.metadata = take_vdb_metadata(in);
  grid.transform_at = in.at();
  const auto transform = in.text();
  const std::size_t doubles = doubles_of(transform);
  if (doubles == 0)
    throw Error("unreadable-volume",
                "grid '" + printable(grid.name) + "' has the unsupported transform " + printable(transform),
                "resample it to uniform voxels");
  in.take(8 * doubles);
  grid.tree_at = in.at();
  if (grid.parent.empty())
    walk_one_of<FloatGrid, DoubleGrid, Vec3SGrid, Int32Grid, BoolGrid, Vec3IGrid>(in, grid);
}

}  // namespace

std::vector<VdbGrid> vdb_grids(std::string_view bytes, const VdbHeader& header) {
  constexpr std::string_view kHalf = "_HalfFloat";
  std::vector<VdbGrid> grids;
  ByteCursor in(bytes, header.end);
  for (std::uint32_t i = 0; i < header.grids; ++i) {
    VdbGrid grid;
    grid.unique_name = in.text();
    grid.name = grid.unique_name.substr(0, grid.unique_name.find('\x1e'));
    grid.type = in.text();
    if (grid.type.ends_with(kHalf)) {
      grid.half = true;
      grid.type.resize(grid.type.size() - kHalf.size());
    }
    grid.parent = in.text();
    const auto at = in.take<std::uint64_t>();
    in.take(8);  // offset of its voxels
    const auto end = in.take<std::uint64_t>();
    if (header.has_offsets) {
      if (at < in.at() || end < at)
        throw damaged(fmt::format("grid {} extends from byte {} to {}", i, at, end));
      in.seek(at);
    }
    read_grid(in, grid);
    if (header.has_offsets)
      in.seek(end);
    else if (!grid.known)
      throw Error("unreadable-volume",
                  "grid '" + printable(grid.name) + "' has the unsupported type " + printable(grid.type) +
                      ", and the file does not contain its end",
                  "write the file without that grid, or with grid offsets");
    grids.push_back(std::move(grid));
  }
  return grids;
}

}  // namespace terrazzo::load_volume
