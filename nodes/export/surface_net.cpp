#include "nodes/export/surface_net.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/disjoint_sets.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

constexpr double kMostMove = 0.45;     // of the way to the next corner of a cell, along each axis
constexpr double kLeastVolume = 0.02;  // of six times a tetrahedron's volume, relative to its cube
// Steps to the neighbors' mean and back, so that bodies keep their volume (Taubin 1995).
constexpr double kForward = 0.5, kBackward = -0.53;

// The cells that fill the box, and the lattice of their corners. Cells at the sides of a volume that tiles
// are halves of voxels: the first and the last one along an axis belong to the same voxel.
class CellLattice {
 public:
  CellLattice(const VoxelSource& id, const VoxelBox& box, const Regions& regions, std::uint64_t memory,
              const Work& work)
      : box_(box) {
    cells_ = box.size + Vec3i::Constant(box.periodic ? 1 : 0);
    points_ = cells_ + Vec3i::Ones();
    const double corners = points_.cast<double>().prod();
    // Regions, numbers of nodes, and pieces; the nodes and triangles of most surfaces need less.
    require_memory(4 * static_cast<double>(box.count()) + 12 * corners, memory, "the surfaces of the volume");
    if (corners > 2147483647.0)
      throw Error(
          "too-large",
          fmt::format("the surfaces need up to {:.0f} nodes; at most 2147483647 are supported", corners),
          "use fewer voxels");
    region_.resize(box.count());
    for (int z = 0; z < box.size.z(); ++z) {
      work.check();
      std::int32_t* plane = region_.data() + z * box.plane();
      id.read(z, z + 1, plane);
      for (std::size_t i = 0; i < box.plane(); ++i) plane[i] = regions.number(plane[i]);
    }
  }
  const Vec3i& cells() const { return cells_; }
  const Vec3i& points() const { return points_; }
  bool wraps() const { return box_.periodic; }
  bool has(const Vec3i& c) const { return (c.array() >= 0).all() && (c.array() < cells_.array()).all(); }
  // −1 outside the box.
  std::int32_t region(const Vec3i& c) const {
    if (!has(c)) return -1;
    const auto along = [&](int a) { return static_cast<std::size_t>(c[a] == box_.size[a] ? 0 : c[a]); };
    return region_[(along(2) * box_.size.y() + along(1)) * box_.size.x() + along(0)];
  }
  std::size_t cell(const Vec3i& c) const {
    return (static_cast<std::size_t>(c.z()) * static_cast<std::size_t>(cells_.y()) +
            static_cast<std::size_t>(c.y())) *
               static_cast<std::size_t>(cells_.x()) +
           c.x();
  }
  std::size_t index(const Vec3i& p) const {
    return (static_cast<std::size_t>(p.z()) * static_cast<std::size_t>(points_.y()) +
            static_cast<std::size_t>(p.y())) *
               static_cast<std::size_t>(points_.x()) +
           p.x();
  }
  Vec3 place(const Vec3i& p) const {
    Vec3 out;
    for (int a = 0; a < 3; ++a) {
      double voxels = p[a];
      if (box_.periodic) voxels = p[a] == 0 ? 0.5 : p[a] == cells_[a] ? box_.size[a] + 0.5 : p[a];
      out[a] = box_.corner[a] + voxels * box_.spacing[a];
    }
    return out;
  }

 private:
  const VoxelBox& box_;
  Vec3i cells_, points_;
  std::vector<std::int32_t> region_;
};

// Connected parts of the regions within the box: the piece of each cell, numbered by their first cells.
// Returns the pieces' regions.
std::vector<std::int32_t> find_pieces(const CellLattice& lattice, std::vector<std::int32_t>& piece) {
  const Vec3i& cells = lattice.cells();
  DisjointSets sets(lattice.cell(cells - Vec3i::Ones()) + 1);
  const auto visit = [&](auto&& f) {
    for (Vec3i c(0, 0, 0); c.z() < cells.z(); ++c.z())
      for (c.y() = 0; c.y() < cells.y(); ++c.y())
        for (c.x() = 0; c.x() < cells.x(); ++c.x()) f(c);
  };
  visit([&](const Vec3i& c) {
    for (int a = 0; a < 3; ++a)
      if (const Vec3i before = c - Vec3i::Unit(a); c[a] > 0 && lattice.region(before) == lattice.region(c))
        sets.join(lattice.cell(before), lattice.cell(c));
  });
  std::vector<std::int32_t> regions;
  piece.assign(sets.count(), -1);
  visit([&](const Vec3i& c) {
    const std::size_t at = lattice.cell(c), first = sets.find(static_cast<std::int32_t>(at));
    if (first == at) {
      piece[at] = regions.size();
      regions.push_back(lattice.region(c));
    }
    piece[at] = piece[first];
  });
  return regions;
}

struct NetBuilder {
  const CellLattice& lattice;
  SurfaceNet& net;
  std::vector<std::int32_t> number;                           // of the node at each point, or −1
  std::vector<Vec3i> point;                                   // of each node
  std::map<std::array<std::int32_t, 3>, std::int32_t> patch;  // by pieces and side
  std::vector<std::int32_t> piece;                            // of each cell

  std::int32_t node(const Vec3i& p) {
    std::int32_t& n = number[lattice.index(p)];
    if (n < 0) {
      n = net.nodes.size();
      net.nodes.push_back(lattice.place(p));
      point.push_back(p);
    }
    return n;
  }
  // The face between the cell c and the one before it along the axis.
  void face(const Vec3i& c, int axis) {
    const std::int32_t before = lattice.region(c - Vec3i::Unit(axis)), after = lattice.region(c);
    if (before == after) return;
    SurfacePatch part;
    part.inside = std::max(before, after);
    part.other = std::min(before, after);
    part.side = after < 0 ? 2 * axis + 1 : before < 0 ? 2 * axis : -1;
    const Vec3i last = c - Vec3i::Unit(axis);
    const Vec3i &in = before > after ? last : c, &out = before > after ? c : last;
    part.inside_piece = piece[lattice.cell(in)];
    if (part.side < 0) {
      part.other_piece = piece[lattice.cell(out)];
    } else if (lattice.wraps()) {
      Vec3i image = in;
      image[axis] = part.side % 2 ? 0 : lattice.cells()[axis] - 1;
      part.other_piece = piece[lattice.cell(image)];
    }
    const auto [it, added] =
        patch.emplace(std::array<std::int32_t, 3>{part.inside_piece, part.other_piece, part.side},
                      static_cast<std::int32_t>(net.patches.size()));
    if (added) net.patches.push_back(part);
    const Vec3i u = Vec3i::Unit((axis + 1) % 3), v = Vec3i::Unit((axis + 2) % 3);
    std::array<std::int32_t, 4> q = {node(c), node(c + u), node(c + u + v), node(c + v)};
    if (before < after) std::swap(q[1], q[3]);  // the normal points away from the larger number
    net.corners.push_back({q[0], q[1], q[2]});
    net.corners.push_back({q[0], q[2], q[3]});
    net.patch_of.insert(net.patch_of.end(), 2, it->second);
  }
};

// Number of surfaces that meet at the edge from a point along an axis, as the number of regions around it.
// The outside counts once for each side: 2 lies within a surface, 3 and more on a line, 0 and 1 in none.
int regions_around(const CellLattice& lattice, const Vec3i& p, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::int32_t found[4];
  int count = 0, sides = 0;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t r = lattice.region(p - (k & 1) * Vec3i::Unit(u) - (k >> 1) * Vec3i::Unit(v));
    if (r >= 0 && std::find(found, found + count, r) == found + count) found[count++] = r;
  }
  for (const int a : {u, v}) sides += p[a] == 0 || p[a] == lattice.cells()[a];
  return count + sides;
}

// Neighbors with which each node is averaged; none if it stays.
struct Neighbors {
  std::vector<std::array<std::int32_t, 6>> of;
  std::vector<int> count;
};

Neighbors neighbors_of(const CellLattice& lattice, const NetBuilder& b, const Work& work) {
  Neighbors out;
  out.of.resize(b.point.size());
  out.count.assign(b.point.size(), 0);
  work.parallel(b.point.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      std::array<std::int32_t, 6> line{}, flat{};
      int lines = 0, flats = 0;
      for (int axis = 0; axis < 3; ++axis)
        for (const int way : {-1, 1}) {
          const Vec3i& p = b.point[n];
          const Vec3i to = p + way * Vec3i::Unit(axis);
          if (to[axis] < 0 || to[axis] > lattice.cells()[axis]) continue;
          const int around = regions_around(lattice, way < 0 ? to : p, axis);
          const std::int32_t other = b.number[lattice.index(to)];
          if (around < 2 || other < 0) continue;
          if (around > 2)
            line[lines++] = other;
          else
            flat[flats++] = other;
        }
      if (lines == 0) {
        out.of[n] = flat;
        out.count[n] = flats;
      }
      if (lines == 2) {
        out.of[n] = line;
        out.count[n] = 2;
      }
    }
  });
  return out;
}

// Moves nodes so that all images of a node move alike, and no surfaces cross: each cube between eight points
// of the lattice is cut into six tetrahedra, of whose faces the surfaces are made (Kuhn 1960). As long as
// every tetrahedron keeps its orientation, they fill the box without overlap.
class Smoother {
 public:
  Smoother(const CellLattice& lattice, NetBuilder& b, const Work& work)
      : lattice_(lattice), b_(b), neighbors_(neighbors_of(lattice, b, work)), next_(b.net.nodes.size()) {
    for (const Vec3i& p : b.point) {
      Vec3i first = p;
      for (int a = 0; a < 3; ++a)
        if (lattice.wraps() && p[a] == lattice.cells()[a]) first[a] = 0;
      image_.push_back(b.number[lattice.index(first)]);
    }
    const Vec3i& cells = lattice.cells();
    for (Vec3i c(0, 0, 0); c.z() < cells.z(); ++c.z())
      for (c.y() = 0; c.y() < cells.y(); ++c.y())
        for (c.x() = 0; c.x() < cells.x(); ++c.x())
          if (const auto nodes = nodes_of(c);
              std::any_of(nodes.begin(), nodes.end(), [](auto n) { return n >= 0; }))
            cubes_.push_back(c);
  }

  // One step of all nodes by `share` of the way to the mean of their neighbors, or away from it if negative.
  void step(double share, const Work& work) {
    std::vector<Vec3>& nodes = b_.net.nodes;
    work.quiet().parallel(next_.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) next_[n] = moved(n, share);
    });
    // Corners of a tetrahedron that would turn stay, with their images; then those of its neighbors may have
    // to.
    std::vector<std::uint8_t> kept(nodes.size(), 0);
    for (std::atomic<bool> again = true; again;) {
      again = false;
      work.quiet().parallel(cubes_.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) keep_turned(cubes_[k], kept, again);
      });
      if (again)
        for (std::size_t n = 0; n < nodes.size(); ++n)
          if (kept[image_[n]]) next_[n] = nodes[n];
    }
    nodes.swap(next_);
  }

 private:
  // The points of a cube are numbered by bits: 1 for x, 2 for y, 4 for z.
  std::array<std::int32_t, 8> nodes_of(const Vec3i& cube) const {
    std::array<std::int32_t, 8> out;
    for (int k = 0; k < 8; ++k) out[k] = b_.number[lattice_.index(cube + Vec3i(k & 1, k >> 1 & 1, k >> 2))];
    return out;
  }
  void keep_turned(const Vec3i& cube, std::vector<std::uint8_t>& kept, std::atomic<bool>& again) const {
    const auto nodes = nodes_of(cube);
    std::array<Vec3, 8> at;
    for (int k = 0; k < 8; ++k) {
      const std::int32_t n = nodes[k];
      at[k] = n >= 0 ? next_[n] : lattice_.place(cube + Vec3i(k & 1, k >> 1 & 1, k >> 2));
    }
    const double least = kLeastVolume * (lattice_.place(cube + Vec3i::Ones()) - lattice_.place(cube)).prod();
    // From corner 0 to corner 7 along the axes, in each of their orders; odd ones have the other orientation.
    constexpr std::size_t kPaths[6][2] = {{1, 3}, {2, 6}, {4, 5}, {2, 3}, {4, 6}, {1, 5}};
    for (std::size_t t = 0; t < 6; ++t) {
      const auto [i, j] = kPaths[t];
      const double volume = (at[i] - at[0]).cross(at[j] - at[0]).dot(at[7] - at[0]) * (t < 3 ? 1 : -1);
      if (volume >= least) continue;
      for (const std::size_t k : {std::size_t{0}, i, j, std::size_t{7}}) {
        if (nodes[k] < 0) continue;
        std::atomic_ref<std::uint8_t> flag(kept[image_[static_cast<std::size_t>(nodes[k])]]);
        if (flag.exchange(1, std::memory_order_relaxed) == 0) again = true;
      }
    }
  }
  Vec3 moved(std::size_t n, double share) const {
    const std::vector<Vec3>& nodes = b_.net.nodes;
    if (neighbors_.count[n] == 0) return nodes[n];
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < neighbors_.count[n]; ++k) sum += nodes[neighbors_.of[n][k]];
    Vec3 to = (1 - share) * nodes[n] + share * sum / neighbors_.count[n];
    const Vec3i& p = b_.point[n];
    const Vec3 from = lattice_.place(p);
    const Vec3 before = lattice_.place(p - Vec3i::Ones()), after = lattice_.place(p + Vec3i::Ones());
    for (int a = 0; a < 3; ++a) {
      // A node on a side stays there to the last bit.
      if (p[a] == 0 || p[a] == lattice_.cells()[a])
        to[a] = from[a];
      else
        to[a] = std::clamp(to[a], from[a] + kMostMove * (before[a] - from[a]),
                           from[a] + kMostMove * (after[a] - from[a]));
    }
    return to;
  }

  const CellLattice& lattice_;
  NetBuilder& b_;
  Neighbors neighbors_;
  std::vector<std::int32_t> image_;  // of each node on the lower sides, or itself
  std::vector<Vec3i> cubes_;         // those with a node
  std::vector<Vec3> next_;
};

}  // namespace

SurfaceNet surface_net(const VoxelSource& id, const VoxelBox& box, const Regions& regions, int smoothing,
                       std::uint64_t memory, const Work& work) {
  const CellLattice lattice(id, box, regions, memory, work);
  SurfaceNet net;
  NetBuilder b{
      lattice,
      net,
      std::vector<std::int32_t>(static_cast<std::size_t>(lattice.points().cast<double>().prod()), -1),
      {},
      {},
      {}};
  net.region_of_piece = find_pieces(lattice, b.piece);
  const Vec3i& cells = lattice.cells();
  for (int z = 0; z <= cells.z(); ++z) {
    work.check();
    for (int y = 0; y <= cells.y(); ++y)
      for (int x = 0; x <= cells.x(); ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3i c(x, y, z);
          if (c[(axis + 1) % 3] < cells[(axis + 1) % 3] && c[(axis + 2) % 3] < cells[(axis + 2) % 3])
            b.face(c, axis);
        }
  }
  if (smoothing > 0) {
    Smoother smoother(lattice, b, work.part(0.3, 0.4));
    for (int k = 0; k < smoothing; ++k) {
      const Work part = work.part(0.4 + 0.6 * k / smoothing, 0.4 + 0.6 * (k + 1) / smoothing);
      smoother.step(kForward, part.part(0, 0.5));
      smoother.step(kBackward, part.part(0.5, 1));
    }
  }
  if (box.periodic)
    for (int a = 0; a < 3; ++a)
      for (std::size_t n = 0; n < b.point.size(); ++n) {
        if (b.point[n][a] != cells[a]) continue;
        Vec3i image = b.point[n];
        image[a] = 0;
        const std::int32_t other = b.number[lattice.index(image)];
        net.periodic[a].emplace_back(static_cast<std::int32_t>(n), other);
        // Equal to the last bit, whatever the order of the sums was.
        const double own = net.nodes[n][a];
        net.nodes[n] = net.nodes[other];
        net.nodes[n][a] = own;
      }
  return net;
}

}  // namespace terrazzo::exporting
