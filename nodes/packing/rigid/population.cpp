#include "nodes/packing/rigid/population.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/common/stereology/size_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kSizes = 0x73697a6573, kShapes = 0x736861706573, kOrder = 0x6f72646572;
constexpr double kRoomy = 3;  // edge of a box that shows many large particles, in the size of the largest

struct Cell {
  int entry, cls;      // entry of the distribution, size class
  double density;      // per mm³
  double mean_volume;  // mm³
  std::int64_t count = 0;
};

// Volume of a particle of unit size.
double unit_volume(const Shape& s) { return s.volume / std::pow(s.size(), 3); }

double bounding_diameter(const Shape& s) {  // of a particle of unit size
  double r = 0;
  for (const auto& v : s.mesh.vertices) r = std::max(r, v.norm());
  return 2 * r / s.size();
}

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

std::vector<Cell> cells_of(const SizeDistribution& d, const Shapes& shapes) {
  double probability = 0, mixed = 0;
  for (const auto& s : shapes.shapes) {
    probability += s.probability;
    mixed += s.probability * unit_volume(s);
  }
  mixed /= probability;
  std::vector<Cell> cells;  // largest class first
  for (int k = static_cast<int>(d.classes()) - 1; k >= 0; --k)
    for (std::size_t e = 0; e < d.shapes.size(); ++e) {
      if (!(d.shapes[e].N_V[k] > 0)) continue;
      const double unit = d.shapes[e].shape < 0 ? mixed : unit_volume(shapes.shapes[d.shapes[e].shape]);
      cells.push_back({static_cast<int>(e), k, d.shapes[e].N_V[k],
                       unit * mean_cube(d.class_edges[k], d.class_edges[k + 1])});
    }
  return cells;
}

// Size of the largest possible particle and its bounding diameter.
void largest(const SizeDistribution& d, const Shapes& shapes, double& size, double& diameter) {
  size = diameter = 0;
  for (const auto& e : d.shapes)
    for (std::size_t k = 0; k < d.classes(); ++k) {
      if (!(e.N_V[k] > 0)) continue;
      size = std::max(size, d.class_edges[k + 1]);
      for (std::size_t s = 0; s < shapes.shapes.size(); ++s)
        if (e.shape == static_cast<int>(s) || (e.shape < 0 && shapes.shapes[s].probability > 0))
          diameter = std::max(diameter, d.class_edges[k + 1] * bounding_diameter(shapes.shapes[s]));
    }
}

Vec3 given_box(const PopulationOptions& o, double size, double diameter) {
  if (o.edges.size() > 3) throw Error("bad-size", "a box has at most three edges", "").parameter("size");
  const Vec3 box(o.edges[0], o.edges[o.edges.size() == 3 ? 1 : 0], o.edges.back());
  if (!box.allFinite() || !(box.minCoeff() > 0))
    throw Error("bad-size", "the box edges must be positive numbers", "").parameter("size");
  if (diameter + o.binder_gap >= box.minCoeff())
    throw Error("box-too-small",
                fmt::format("a particle of size {:.4g} mm has an extent of {:.4g} mm, which does not fit "
                            "the box edge of {:.4g} mm: it would touch its own periodic image",
                            size, diameter, box.minCoeff()),
                fmt::format("make the box at least {:.4g} mm, preferably {:.4g} mm",
                            1.05 * diameter + o.binder_gap, kRoomy * size))
        .parameter("size");
  return box;
}

// The edge of a cube for about `count` particles. Large particles need a larger box, which may hold up to
// most_enlarged() particles. `least`: the smallest edge at which the largest particle fits.
double automatic_edge(const PopulationOptions& o, double density, double size, double diameter, double least,
                      Population& out) {
  const double edge = std::cbrt(static_cast<double>(o.count) / density);
  const double wanted = std::max(kRoomy * size, 1.2 * diameter + o.binder_gap);
  if (edge >= wanted) return edge;
  const double capped = std::cbrt(most_enlarged(o) / density);
  const double chosen = std::max({edge, std::min(wanted, capped), std::min(wanted, least)});
  if (chosen < wanted)
    out.notes.push_back(fmt::format(
        "the box is only {:.2f} times the largest particle; a larger one would need {:.3g} particles",
        chosen / size, density * wanted * wanted * wanted));
  return chosen;
}

double sum_of_densities(const std::vector<Cell>& cells) {
  double sum = 0;
  for (const Cell& c : cells) sum += c.density;
  return sum;
}

// Leaves the smallest particles to the binder until the smallest box in which the largest particle fits holds
// no more than `count` or kMostKept particles: as many of a class as necessary, and then those of the next.
// Class by class, all but the largest may be left out as a whole.
void leave_out_smallest(std::vector<Cell>& cells, const SizeDistribution& d, const PopulationOptions& o,
                        double least, Population& out) {
  const double volume = least * least * least;
  const double most = std::max<double>(o.count, kMostKept) / volume;
  const double before = sum_of_densities(cells);
  while (sum_of_densities(cells) > most && cells.front().cls > cells.back().cls) {
    const int cls = cells.back().cls;
    const auto first = std::find_if(cells.begin(), cells.end(), [&](const Cell& c) { return c.cls == cls; });
    const std::vector<Cell> smallest(first, cells.end());
    cells.erase(first, cells.end());
    const double kept = std::max(0.0, (most - sum_of_densities(cells)) / sum_of_densities(smallest));
    for (Cell c : smallest) {
      out.left_out_fraction += (1 - kept) * c.density * c.mean_volume;
      c.density *= kept;
      if (kept > 0) cells.push_back(c);
    }
    out.left_out_size = d.class_edges[cls + 1];
    if (kept > 0) break;
  }
  if (out.left_out_fraction > 0)
    out.notes.push_back(fmt::format(
        "particles smaller than {:.4g} mm that would fill {:.3g} of the volume are left to the binder: a box "
        "in which the largest particle fits would hold {:.3g} particles with them, {:.3g} without; to keep "
        "them, set `count` to {:.3g} or more",
        out.left_out_size, out.left_out_fraction, before * volume, sum_of_densities(cells) * volume,
        std::ceil(before * volume)));
}

// Rounds the running sum of the expected counts, shifted by `phase`.
double round_counts(std::vector<Cell>& cells, double volume, double phase) {
  double sum = phase, filled = 0;
  std::int64_t before = 0;
  for (auto& c : cells) {
    sum += c.density * volume;
    const std::int64_t now = std::floor(sum);
    c.count = now - before;
    before = now;
    filled += static_cast<double>(c.count) * c.mean_volume;
  }
  return filled;
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

// Scales the number densities if the volume fraction is to be kept, or if they overfill the box. Returns
// their sum.
double scale_densities(std::vector<Cell>& cells, const SizeDistribution& d, const PopulationOptions& o,
                       Population& out) {
  double density = 0, computed = 0;
  for (const auto& c : cells) {
    density += c.density;
    computed += c.density * c.mean_volume;
  }
  if (cells.empty() || !(density > 0) || !(computed > 0))
    throw Error("no-particles", "the distribution has no particles: all its number densities are 0",
                "check the profiles or densities from which it is computed");
  out.requested_fraction = computed;
  if (o.conserve == Conserve::VolumeFraction && d.volume_fraction > 0 && std::isfinite(d.volume_fraction)) {
    out.requested_fraction = d.volume_fraction;
    const double factor = d.volume_fraction / computed;
    if (factor < 0.93 || factor > 1.07) {
      out.notes.push_back(
          fmt::format("with these shapes the number densities imply a volume fraction of {:.3f}, not {:.3f}; "
                      "they were scaled by {:.3f} to keep the volume fraction",
                      computed, d.volume_fraction, factor));
      for (auto& c : cells) c.density *= factor;
      density *= factor;
    }
  }
  if (o.fills_space && out.requested_fraction > 1) {
    out.notes.push_back(
        fmt::format("the number densities imply a volume fraction of {:.3f}; they were scaled to "
                    "fill the box",
                    out.requested_fraction));
    for (auto& c : cells) c.density /= out.requested_fraction;
    density /= out.requested_fraction;
    out.requested_fraction = 1;
  }
  if (!(out.requested_fraction < 1) && !o.fills_space)
    throw Error("impossible-density",
                fmt::format("the particles would fill {:.3f} of the box; it must be less than 1",
                            out.requested_fraction),
                "lower the densities or the volume fraction");
  return density;
}

// Throws if the box would hold more than the allowed number of particles.
void check_expected(double expected, const Vec3& box, const PopulationOptions& o) {
  // Exactly `most` particles are allowed despite the rounding of their box.
  if (expected > static_cast<double>(o.most) + 0.5)
    throw Error(
        "too-many-particles",
        fmt::format(
            "the box of {:.4g} × {:.4g} × {:.4g} mm would hold {:.3g} particles; at most {} are allowed",
            box[0], box[1], box[2], expected, o.most),
        o.edges.empty() ? "lower `count`" : "make the box smaller, or leave out the smallest classes")
        .parameter(o.edges.empty() ? "count" : "size");
}

// Rounds the counts with the phase that best matches the volume `target` of the particles.
void choose_counts(std::vector<Cell>& cells, double volume, double target) {
  double best_phase = 0.5, least = 1e300;
  for (int k = 0; k < 32; ++k) {
    const double phase = (k + 0.5) / 32;
    const double error = std::abs(round_counts(cells, volume, phase) - target);
    if (error < least - 1e-12 * target) {
      least = error;
      best_phase = phase;
    }
  }
  round_counts(cells, volume, best_phase);
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

double most_enlarged(const PopulationOptions& o) {
  const double count = o.count;
  return std::max(count, std::min(10 * count, kMostEnlarged));
}

Population populate(const SizeDistribution& d, const Shapes& shapes, const Particles* start,
                    const PopulationOptions& o, const Work& work) {
  check(d, shapes);
  check_void_classes(d, o);
  Population out;
  auto cells = cells_of(d, shapes);
  double density = scale_densities(cells, d, o, out);

  double size, diameter;
  largest(d, shapes, size, diameter);
  Vec3 box;
  if (o.edges.empty()) {
    const double least = std::max(1.5 * size, 1.1 * diameter + o.binder_gap);
    leave_out_smallest(cells, d, o, least, out);
    density = sum_of_densities(cells);
    box = Vec3::Constant(automatic_edge(o, density, size, diameter, least, out));
  } else {
    box = given_box(o, size, diameter);
  }
  out.target_fraction = out.requested_fraction - out.left_out_fraction;
  const double volume = box.prod(), expected = density * volume;
  check_expected(expected, box, o);

  const double target = out.target_fraction * volume;
  choose_counts(cells, volume, target);
  out.expected.assign(d.classes(), 0);
  for (const Cell& cell : cells) out.expected[cell.cls] += cell.density * volume;
  std::vector<Member> members = members_of(cells, d, shapes, start, o.seed);
  if (members.empty())
    throw Error("no-particles",
                fmt::format("the box would hold only {:.2g} particles on average, so it is empty", expected),
                "make the box larger")
        .parameter("size");
  choose_sizes(members, d, shapes, target, work);
  sort_members(members, shapes);

  // If the size of the box is automatic, adjust it to compensate for the remaining rounding error.
  const double filled = total_volume(members, shapes);
  out.particles.box = box;
  const double stretch = std::cbrt(filled / target);
  if (o.edges.empty() && stretch > 0.98 && stretch < 1.02 &&
      box.minCoeff() * stretch > diameter + o.binder_gap)
    out.particles.box *= stretch;
  out.fraction = filled / out.particles.box.prod();
  fill_particles(members, d, shapes, start, o, out);
  return out;
}

}  // namespace terrazzo::packing
