// Canonical encoding of OpenVDB trees: equal voxels produce equal bytes, independent of the tree's history.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "nodes/data/grids.h"
#include "runtime/codec.h"

namespace terrazzo {

// Nodes with identical voxels are written as tiles, and background tiles are omitted, so the bytes depend
// only on values and active states. OpenVDB's own stream format is not used: it depends on the tree's
// history, and its reader trusts its input.
template <class Tree>
class TreeCodec {
 public:
  using Root = typename Tree::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  using Leaf = typename Tree::LeafNodeType;
  using T = typename Tree::ValueType;
  static_assert(std::is_same_v<typename Upper::ChildNodeType::ChildNodeType, Leaf>,
                "only trees of three levels");

  static void encode(const Tree& tree, Writer& w) {
    const Root& root = tree.root();
    w.pod(root.background());
    std::vector<RootTile> tiles;
    std::vector<const Upper*> children;
    for (auto it = root.cbeginValueAll(); it; ++it)
      add_tile(tiles, {it.getCoord(), {*it, it.isValueOn()}}, root.background());
    for (auto it = root.cbeginChildOn(); it; ++it) {
      Tile same;
      if (uniform(*it, same))
        add_tile(tiles, {it.getCoord(), same}, root.background());
      else
        children.push_back(&*it);
    }
    std::sort(tiles.begin(), tiles.end(), [](const auto& a, const auto& b) { return a.origin < b.origin; });
    w.pod<std::uint64_t>(tiles.size());
    for (const auto& t : tiles) {
      write_coord(t.origin, w);
      w.pod(t.tile.value);
      w.pod<std::uint8_t>(t.tile.active);
    }
    w.pod<std::uint64_t>(children.size());
    for (const Upper* child : children) {
      write_coord(child->origin(), w);
      write_node(*child, w);
    }
  }

  // Throws Error "damaged" if the bytes are not a valid tree.
  static typename Tree::Ptr decode(Reader& r) {
    auto tree = std::make_shared<Tree>(read_value(r));
    std::set<openvdb::Coord> taken;
    const std::size_t tiles = r.count(12 + sizeof(T) + 1);
    for (std::size_t i = 0; i < tiles; ++i) {
      const openvdb::Coord at = read_coord(r);
      const T value = read_value(r);
      if (!taken.insert(at).second) damaged();
      tree->root().addTile(at, value, read_flag(r));
    }
    const std::size_t children = r.count(12 + kMaskBytes<Upper>);
    for (std::size_t i = 0; i < children; ++i) {
      const openvdb::Coord at = read_coord(r);
      if (!taken.insert(at).second) damaged();
      auto child = std::make_unique<Upper>(at, tree->background());
      read_node(*child, tree->background(), r);
      if (!tree->root().addChild(child.get())) damaged();
      child.release();
    }
    return tree;
  }

 private:
  struct Tile {
    T value{};
    bool active = false;
  };
  struct RootTile {
    openvdb::Coord origin;
    Tile tile;
  };
  template <class Node>
  static constexpr std::size_t kMaskBytes = Node::NUM_VALUES / 8;

  [[noreturn]] static void damaged() { throw Error("damaged", "the stored volume is not a valid tree"); }
  static bool same(const T& a, const T& b) { return std::memcmp(&a, &b, sizeof(T)) == 0; }

  static void add_tile(std::vector<RootTile>& tiles, const RootTile& t, const T& background) {
    if (t.tile.active || !same(t.tile.value, background)) tiles.push_back(t);
  }

  // Whether all voxels of a node have the same value and state.
  static bool uniform(const Leaf& leaf, Tile& out) {
    if (!leaf.getValueMask().isOn() && !leaf.getValueMask().isOff()) return false;
    out = {leaf.getValue(0), leaf.isValueOn(0)};
    for (openvdb::Index i = 1; i < Leaf::SIZE; ++i)
      if (!same(leaf.getValue(i), out.value)) return false;
    return true;
  }
  template <class Node>
  static bool uniform(const Node& node, Tile& out) {
    for (openvdb::Index i = 0; i < Node::NUM_VALUES; ++i) {
      Tile t;
      if (node.getChildMask().isOn(i)) {
        if (!uniform(*node.getTable()[i].getChild(), t)) return false;
      } else {
        t = {node.getTable()[i].getValue(), node.getValueMask().isOn(i)};
      }
      if (i == 0)
        out = t;
      else if (t.active != out.active || !same(t.value, out.value))
        return false;
    }
    return true;
  }

  // Run-length encoding as (length, value), since inactive voxels mostly have one value.
  class Runs {
   public:
    void add(const T& v) {
      if (!runs_.empty() && same(runs_.back().second, v))
        ++runs_.back().first;
      else
        runs_.emplace_back(1, v);
    }
    void write(Writer& w) const {
      for (const auto& [length, value] : runs_) {
        w.pod<std::uint32_t>(length);
        w.pod(value);
      }
    }

   private:
    std::vector<std::pair<std::uint32_t, T>> runs_;
  };
  class RunReader {
   public:
    RunReader(Reader& r, std::size_t total) : r_(r), left_(total) {}
    T next() {
      if (run_ == 0) {
        run_ = r_.pod<std::uint32_t>();
        value_ = r_.pod<T>();
        if (run_ == 0 || run_ > left_) damaged();
        left_ -= run_;
      }
      --run_;
      return value_;
    }

   private:
    Reader& r_;
    std::size_t left_;
    std::uint32_t run_ = 0;
    T value_{};
  };

  template <class Mask>
  static void write_mask(const Mask& mask, Writer& w) {
    for (openvdb::Index i = 0; i < Mask::WORD_COUNT; ++i) w.pod(mask.template getWord<std::uint64_t>(i));
  }
  template <class Mask>
  static Mask read_mask(Reader& r) {
    Mask mask;
    for (openvdb::Index i = 0; i < Mask::WORD_COUNT; ++i)
      mask.template getWord<std::uint64_t>(i) = r.pod<std::uint64_t>();
    return mask;
  }

  static void write_node(const Leaf& leaf, Writer& w) {
    write_mask(leaf.getValueMask(), w);
    T active[Leaf::SIZE];
    std::size_t count = 0;
    Runs inactive;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
      if (leaf.isValueOn(i))
        active[count++] = leaf.getValue(i);
      else
        inactive.add(leaf.getValue(i));
    w.bytes(active, count * sizeof(T));
    inactive.write(w);
  }
  static void read_node(Leaf& leaf, const T&, Reader& r) {
    const auto mask = read_mask<typename Leaf::NodeMaskType>(r);
    T active[Leaf::SIZE];
    const std::size_t count = mask.countOn();
    if constexpr (std::is_same_v<T, bool>)
      for (std::size_t i = 0; i < count; ++i) active[i] = read_flag(r);
    else
      r.bytes(active, count * sizeof(T));
    RunReader inactive(r, Leaf::SIZE - count);
    std::size_t at = 0;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
      leaf.setValueOnly(i, mask.isOn(i) ? active[at++] : inactive.next());
    leaf.setValueMask(mask);
  }
  template <class Node>
  static void write_node(const Node& node, Writer& w) {
    using Mask = typename Node::NodeMaskType;
    Mask child_mask, active;
    Runs tiles;
    for (openvdb::Index i = 0; i < Node::NUM_VALUES; ++i) {
      Tile t;
      if (node.getChildMask().isOn(i)) {
        if (!uniform(*node.getTable()[i].getChild(), t)) {
          child_mask.setOn(i);
          continue;
        }
      } else {
        t = {node.getTable()[i].getValue(), node.getValueMask().isOn(i)};
      }
      tiles.add(t.value);
      if (t.active) active.setOn(i);
    }
    write_mask(child_mask, w);
    write_mask(active, w);
    tiles.write(w);
    for (auto it = child_mask.beginOn(); it; ++it) write_node(*node.getTable()[it.pos()].getChild(), w);
  }
  template <class Node>
  static void read_node(Node& node, const T& background, Reader& r) {
    using Mask = typename Node::NodeMaskType;
    using Child = typename Node::ChildNodeType;
    const auto child_mask = read_mask<Mask>(r);
    const auto active = read_mask<Mask>(r);
    RunReader tiles(r, child_mask.countOff());
    for (openvdb::Index i = 0; i < Node::NUM_VALUES; ++i)
      if (!child_mask.isOn(i)) node.addTile(i, tiles.next(), active.isOn(i));
    for (auto it = child_mask.beginOn(); it; ++it) {
      auto child = std::make_unique<Child>(node.offsetToGlobalCoord(it.pos()), background);
      read_node(*child, background, r);
      if (!node.addChild(child.get())) damaged();
      child.release();
    }
  }

  static void write_coord(const openvdb::Coord& c, Writer& w) {
    for (int i = 0; i < 3; ++i) w.pod<std::int32_t>(c[i]);
  }
  static openvdb::Coord read_coord(Reader& r) {
    openvdb::Coord c;
    for (int i = 0; i < 3; ++i) c[i] = r.pod<std::int32_t>();
    if ((c & ~(static_cast<std::int32_t>(Upper::DIM) - 1)) != c) damaged();
    return c;
  }
  static T read_value(Reader& r) {
    if constexpr (std::is_same_v<T, bool>)
      return read_flag(r);
    else
      return r.pod<T>();
  }
  static bool read_flag(Reader& r) {
    const auto v = r.pod<std::uint8_t>();
    if (v > 1) damaged();
    return v;
  }
};

}  // namespace terrazzo
