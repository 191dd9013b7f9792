#include "nodes/packing/rigid/population/counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/size_kernel.h"

namespace terrazzo::packing {

double unit_volume(const Shape& s) { return s.volume / std::pow(s.size(), 3); }

namespace {

constexpr double kRoomy = 3;  // edge of a box that shows many large particles, in the size of the largest

double bounding_diameter(const Shape& s) {  // of a particle of unit size
  double r = 0;
  for (const auto& v : s.mesh.vertices) r = std::max(r, v.norm());
  return 2 * r / s.size();
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
// The largest class always stays.
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

}  // namespace

double most_enlarged(const PopulationOptions& o) {
  const double count = o.count;
  return std::max(count, std::min(10 * count, kMostEnlarged));
}

PopulationCounts count_particles(const SizeDistribution& d, const Shapes& shapes, const PopulationOptions& o,
                                 Population& out) {
  PopulationCounts counts;
  auto& cells = counts.cells;
  cells = cells_of(d, shapes);
  double density = scale_densities(cells, d, o, out), size;
  largest(d, shapes, size, counts.diameter);
  if (o.edges.empty()) {
    const double least = std::max(1.5 * size, 1.1 * counts.diameter + o.binder_gap);
    leave_out_smallest(cells, d, o, least, out);
    density = sum_of_densities(cells);
    counts.box = Vec3::Constant(automatic_edge(o, density, size, counts.diameter, least, out));
  } else {
    counts.box = given_box(o, size, counts.diameter);
  }
  out.target_fraction = out.requested_fraction - out.left_out_fraction;
  const double volume = counts.box.prod();
  counts.expected = density * volume;
  check_expected(counts.expected, counts.box, o);
  choose_counts(cells, volume, out.target_fraction * volume);
  out.expected.assign(d.classes(), 0);
  for (const Cell& cell : cells) out.expected[cell.cls] += cell.density * volume;
  return counts;
}

}  // namespace terrazzo::packing
