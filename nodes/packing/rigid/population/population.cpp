#include "nodes/packing/rigid/population/population.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"
#include "nodes/packing/rigid/population/counts.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kSizes = 0x73697a6573, kShapes = 0x736861706573, kOrder = 0x6f72646572;

void check(const SizeDistribution& d, const Shapes& shapes) {
  const auto bad = [](const std::string& what) {
    throw Error("bad-distribution", what, "check the node that makes the distribution");
  };
  if (shapes.shapes.empty())
    throw Error("no-shapes", "there is no shape to pack", "connect a node that outputs shapes");
  double probability = 0;
  for (const auto& s : shapes.shapes) {
    if (s.mesh.triangles.empty() || !(s.volume > 0) || !(s.size() > 0) || !std::isfinite(s.volume))
      throw Error("bad-shape", fmt::format("shape '{}' has no volume", s.name),
                  "use a closed mesh with outward orientation");
    if (!(s.probability >= 0))
      throw Error("bad-shape", fmt::format("the probability of shape '{}' must be 0 or more; it is {}",
                                           s.name, s.probability));
    if (s.probability > 0)
      if (const auto faults = mesh_faults(s.mesh); !faults.empty())
        throw Error("open-mesh",
                    fmt::format("the mesh of shape '{}' is not closed: {}", s.name, faults.front()),
                    "close its holes, for example with `repair` of LoadMesh");
    probability += s.probability;
  }
  if (!(probability > 0)) throw Error("bad-shape", "all shapes have probability 0");
  if (d.class_edges.size() < 2) bad("the distribution has no size class");
  for (std::size_t k = 0; k < d.class_edges.size(); ++k) {
    if (!std::isfinite(d.class_edges[k]) || d.class_edges[k] < 0)
      bad(fmt::format("class edges must be finite and 0 or more; one is {}", d.class_edges[k]));
    if (k > 0 && d.class_edges[k] < d.class_edges[k - 1]) bad("the class edges are not in increasing order");
  }
  for (const auto& e : d.shapes) {
    if (e.N_V.size() != d.classes())
      bad(fmt::format("an entry has {} classes, but the distribution has {}", e.N_V.size(), d.classes()));
    if (e.shape < -1 || e.shape >= count_of(shapes.shapes))
      bad(fmt::format("an entry refers to shape {}, but there are only {} shapes", e.shape,
                      shapes.shapes.size()));
    for (std::size_t k = 0; k < e.N_V.size(); ++k) {
      if (!(e.N_V[k] >= 0) || !std::isfinite(e.N_V[k]))
        bad(fmt::format("number densities must be finite and 0 or more; one is {}", e.N_V[k]));
      if (e.N_V[k] > 0 && !(d.class_edges[k + 1] > 0)) bad("a class with particles has size 0");
    }
  }
}

struct Member {
  int entry, size_class, shape;
  double rank;  // 0…1 within its class
  double size = 0;
  int start = -1;  // index into the start particles, −1 for new ones
};

// A permutation of 0 … n − 1 that depends only on seed and item.
std::vector<std::size_t> shuffled(std::size_t n, std::uint64_t seed, std::uint64_t item) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed, kOrder, item);
  for (std::size_t k = n; k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
  return order;
}

void add_members(const Cell& cell, std::size_t index, std::size_t n, const SizeDistribution& d,
                 const Shapes& shapes, std::uint64_t seed, std::vector<Member>& members) {
  const int fixed = d.shapes[cell.entry].shape;
  Random random(seed, kShapes, index), jitter(seed, kSizes, index);
  const auto order = shuffled(n, seed, index);
  double total = 0;
  for (const auto& s : shapes.shapes) total += s.probability;
  const double phase = random.uniform();
  for (std::size_t k = 0; k < n; ++k) {
    int shape = fixed;
    // Systematic sampling: each shape occurs in proportion to its probability, to within one.
    if (fixed < 0) {
      const double at = (static_cast<double>(order[k]) + phase) / static_cast<double>(n) * total;
      double sum = 0;
      for (std::size_t s = 0; s < shapes.shapes.size(); ++s) {
        if (shapes.shapes[s].probability > 0) shape = static_cast<int>(s);
        sum += shapes.shapes[s].probability;
        if (at < sum) break;
      }
    }
    members.push_back(
        {cell.entry, cell.cls, shape, (static_cast<double>(k) + jitter.uniform()) / static_cast<double>(n)});
  }
}

double total_volume(const std::vector<Member>& members, const Shapes& shapes) {
  double v = 0;
  for (const auto& m : members) v += unit_volume(shapes.shapes[m.shape]) * m.size * m.size * m.size;
  return v;
}

// Raises the ranks within their classes to a common power so that the volume matches as closely as possible.
void choose_sizes(std::vector<Member>& members, const SizeDistribution& d, const Shapes& shapes,
                  double volume, const Work& work) {
  const auto apply = [&](double exponent) {
    work.check();
    for (auto& m : members) {
      if (m.start >= 0) continue;
      const double lo = d.class_edges[m.size_class], hi = d.class_edges[m.size_class + 1];
      m.size = lo + (hi - lo) * std::pow(m.rank, exponent);
      if (!(m.size > 0)) m.size = 1e-3 * hi;
    }
    return total_volume(members, shapes);
  };
  double lo = -2, hi = 2;  // log of the exponent: a larger exponent means less volume
  for (int k = 0; k < 40; ++k) {
    const double mid = 0.5 * (lo + hi);
    (apply(std::exp(mid)) > volume ? lo : hi) = mid;
  }
  apply(std::exp(0.5 * (lo + hi)));
}

void check_void_classes(const SizeDistribution& d, const PopulationOptions& o) {
  for (const std::int64_t cls : o.void_classes)
    if (std::none_of(d.shapes.begin(), d.shapes.end(), [&](const auto& e) { return e.cls == cls; }))
      throw Error("no-such-class", fmt::format("the distribution has no class {}", cls),
                  "use a class of the distribution, or all")
          .parameter("voids");
}

// Whether particle i of `start` can be one of these.
bool fits_cell(const Particles& start, std::size_t i, const Cell& cell, const SizeDistribution& d,
               const Shapes& shapes) {
  const auto& entry = d.shapes[cell.entry];
  const double lo = d.class_edges[cell.cls] * (1 - 1e-9), hi = d.class_edges[cell.cls + 1] * (1 + 1e-9);
  if (start.cls[i] != entry.cls || start.size[i] < lo || start.size[i] > hi) return false;
  if (start.shape[i] < 0 || start.shape[i] >= count_of(shapes.shapes)) return false;
  if (entry.shape >= 0 && start.shape[i] != entry.shape) return false;
  return start.position[i].allFinite() && start.orientation[i].norm() > 1e-6;
}

// The particles of all cells: first those of `start` for which a cell has room, then new ones.
std::vector<Member> members_of(const std::vector<Cell>& cells, const SizeDistribution& d,
                               const Shapes& shapes, const Particles* start, std::uint64_t seed) {
  std::vector<Member> members;
  std::vector<bool> used(start ? start->count() : 0, false);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const Cell& cell = cells[c];
    std::int64_t have = 0;
    for (std::size_t i = 0; i < used.size() && have < cell.count; ++i) {
      if (used[i] || !fits_cell(*start, i, cell, d, shapes)) continue;
      used[i] = true;
      members.push_back({cell.entry, cell.cls, start->shape[i], 0, start->size[i], static_cast<int>(i)});
      ++have;
    }
    add_members(cell, c, static_cast<std::size_t>(cell.count - have), d, shapes, seed, members);
  }
  return members;
}

// Puts kept particles first, in their order, then the others from the largest.
void sort_members(std::vector<Member>& members, const Shapes& shapes) {
  const auto radius = [&](const Member& m) {
    return std::cbrt(unit_volume(shapes.shapes[m.shape])) * m.size;
  };
  std::stable_sort(members.begin(), members.end(), [&](const Member& a, const Member& b) {
    if ((a.start >= 0) != (b.start >= 0)) return a.start >= 0;
    if (a.start >= 0) return a.start < b.start;
    return radius(a) > radius(b);
  });
}

// Gives particle i the place of the kept one.
void keep_place(Particles& p, std::size_t i, const Particles& start, std::size_t from) {
  p.position[i] = start.position[from];
  if (start.box != p.box) p.position[i] = p.position[i].cwiseQuotient(start.box).cwiseProduct(p.box);
  p.position[i] = wrap_point(p.position[i], p.box);
  p.orientation[i] = start.orientation[from];
  if (std::abs(p.orientation[i].norm() - 1) > 1e-9) p.orientation[i].normalize();
  if (!p.is_void(i)) p.color[i] = start.color[from];
}

// Turns the members into particles of a box that is known.
void fill_particles(const std::vector<Member>& members, const SizeDistribution& d, const Shapes& shapes,
                    const Particles* start, const PopulationOptions& o, Population& out) {
  Particles& p = out.particles;
  p.resize(members.size());
  if (o.all_void || !o.void_classes.empty()) p.voids.resize(members.size());
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Member& m = members[i];
    p.shape[i] = m.shape;
    p.cls[i] = d.shapes[m.entry].cls;
    p.size[i] = m.size;
    p.scale[i] = m.size / shapes.shapes[m.shape].size();
    out.size_class.push_back(m.size_class);
    if (!p.voids.empty())
      p.voids[i] = o.all_void ||
                   std::find(o.void_classes.begin(), o.void_classes.end(), p.cls[i]) != o.void_classes.end();
    if (p.is_void(i)) p.color[i].setZero();  // a hole looks dark in a section
    if (m.start < 0) continue;
    ++out.kept;
    keep_place(p, i, *start, m.start);
  }
}

}  // namespace

Population populate(const SizeDistribution& d, const Shapes& shapes, const Particles* start,
                    const PopulationOptions& o, const Work& work) {
  check(d, shapes);
  check_void_classes(d, o);
  Population out;
  const PopulationCounts counts = count_particles(d, shapes, o, out);
  const Vec3& box = counts.box;
  std::vector<Member> members = members_of(counts.cells, d, shapes, start, o.seed);
  if (members.empty())
    throw Error(
        "no-particles",
        fmt::format("the box would hold only {:.2g} particles on average, so it is empty", counts.expected),
        "make the box larger")
        .parameter("size");
  const double target = out.target_fraction * box.prod();
  choose_sizes(members, d, shapes, target, work);
  sort_members(members, shapes);

  // If the size of the box is automatic, adjust it to compensate for the remaining rounding error.
  const double filled = total_volume(members, shapes);
  out.particles.box = box;
  const double stretch = std::cbrt(filled / target);
  if (o.edges.empty() && stretch > 0.98 && stretch < 1.02 &&
      box.minCoeff() * stretch > counts.diameter + o.binder_gap)
    out.particles.box *= stretch;
  out.fraction = filled / out.particles.box.prod();
  fill_particles(members, d, shapes, start, o, out);
  return out;
}

}  // namespace terrazzo::packing
