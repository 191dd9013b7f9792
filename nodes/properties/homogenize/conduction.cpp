#include "nodes/properties/homogenize/conduction.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "nodes/data/indices.h"
#include "nodes/properties/homogenize/cells.h"
#include "nodes/properties/homogenize/connected.h"
#include "nodes/properties/homogenize/multigrid.h"
#include "nodes/properties/homogenize/vectors.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

// One conduction problem: the cells that carry flow, and how much a face of each axis counts.
struct Model {
  VoxelBox box;
  std::shared_ptr<const std::vector<Cells>> levels;
  std::vector<float> k;  // of each cell, relative to the largest
  Vec3 weight;           // of faces: (shortest edge / edge along the axis)²

  const Cells& cells() const { return levels->front(); }
  // At a given value of both ends of an axis: of the half voxel to the end.
  float to_end(std::size_t cell, int axis) const { return static_cast<float>(2 * weight[axis] * k[cell]); }
};

// Faces with the harmonic mean of both voxels, each of which conducts half of the way.
Conductances faces_of(const Model& m, const Work& work) {
  Conductances out;
  for (int a = 0; a < 3; ++a) {
    out.face[a].assign(m.k.size(), 0);
    each_segment(m.cells(), work, [&](const Segment& s, int) {
      for (int i = 0; i < s.length; ++i) {
        const float here = m.k[s.at + i], there = m.k[s.next(a, i)];
        if (there > 0)
          out.face[a][s.at + i] = static_cast<float>(m.weight[a] * 2 / (1.0 / here + 1.0 / there));
      }
    });
  }
  return out;
}

// The energy of x with a mean slope of `step` across each voxel of an axis: Σ g (difference)² over all faces.
double energy_of(const Multigrid& system, const std::vector<double>& x, int axis, double step,
                 const Work& work) {
  double out = 0;
  for (int a = 0; a < 3; ++a) {
    const std::vector<float>& g = system.face(a);
    const double mean = a == axis ? step : 0;
    out += sum_over(system.cells(), work, [&](const Segment& s, int i, int) {
      return g[s.at + i] * std::pow(x[s.next(a, i)] - x[s.at + i] + mean, 2);
    });
  }
  return out;
}

// Flow at the centers of voxels: the mean of both faces of each axis. `step`: the mean slope times the edge,
// if it is not part of x. `length`: between the faces with fixed values 0 and `length`; 0: periodic.
std::vector<float> flow_of(const Model& m, const Multigrid& system, const std::vector<double>& x, int axis,
                           double step, double length, const Work& work) {
  std::vector<float> out(m.k.size(), 0);
  each_segment(m.cells(), work, [&](const Segment& s, int z) {
    for (int i = 0; i < s.length; ++i) {
      const std::size_t at = s.at + i;
      double square = 0;
      for (int a = 0; a < 3; ++a) {
        const std::size_t next = s.next(a, i), before = s.previous(a, i);
        const double mean = a == axis ? step : 0;
        double flow = system.face(a)[at] * (x[next] - x[at] + mean) +
                      system.face(a)[before] * (x[at] - x[before] + mean);
        if (length > 0 && a == axis) {
          if (coordinate(s, i, z, a) == 0) flow += m.to_end(at, a) * x[at];
          if (coordinate(s, i, z, a) + 1 == m.box.size[a]) flow += m.to_end(at, a) * (length - x[at]);
        }
        square += std::pow(0.5 * flow / (m.weight[a] * m.box.spacing[a]), 2);
      }
      out[at] = static_cast<float>(std::sqrt(square));
    }
  });
  return out;
}

void keep_worst(Solved& all, const Convergence& one) {
  all.iterations = std::max(all.iterations, one.iterations);
  all.residual = std::max(all.residual, one.residual);
}

// T = slope · position + x, with a periodic x.
void solve_periodic(const Model& m, Multigrid& system, int axis, const Accuracy& accuracy, Solved& out,
                    const Work& work) {
  const double step = m.box.spacing[axis], voxels = static_cast<double>(m.box.count());
  std::vector<double> b(m.k.size(), 0), x;
  const std::vector<float>& g = system.face(axis);
  each_segment(m.cells(), work, [&](const Segment& s, int) {
    for (int i = 0; i < s.length; ++i)
      b[s.at + i] = step * (static_cast<double>(g[s.at + i]) - g[s.previous(axis, i)]);
  });
  const double energy = step * step * sum_of(g, work);  // of a uniform slope
  keep_worst(out, solve(system, b, energy, x, accuracy, work));
  for (int a = 0; a < 3; ++a) {
    if (a == axis) continue;
    const double flow = sum_over(m.cells(), work, [&](const Segment& s, int i, int) {
      return system.face(a)[s.at + i] * (x[s.next(a, i)] - x[s.at + i]);
    });
    out.effective(a, axis) = flow / (m.weight[a] * m.box.spacing[a] * voxels);
  }
  // The diagonal from the energy, whose error is the square of that of x.
  out.effective(axis, axis) =
      energy_of(system, x, axis, step, work) / (voxels * step * step * m.weight[axis]);
  if (!out.potential.empty()) return;
  out.flow = of_voxels(m.cells(), flow_of(m, system, x, axis, step, 0, work), work);
  out.potential = of_voxels(m.cells(), x, work);
}

// T = 0 at the lower face and the length at the upper one, so that the mean slope is 1.
void solve_fixed(const Model& m, int axis, const Accuracy& accuracy, Solved& out, const Work& work) {
  const Vec3i& n = m.box.size;
  const double step = m.box.spacing[axis], length = n[axis] * step;
  Conductances faces = faces_of(m, work);
  faces.sink.assign(m.k.size(), 0);
  std::vector<double> b(m.k.size(), 0), x;
  each_segment(m.cells(), work, [&](const Segment& s, int z) {
    for (int i = 0; i < s.length; ++i) {
      const int at = coordinate(s, i, z, axis);
      const float end = m.to_end(s.at + i, axis);
      if (at == 0) faces.sink[s.at + i] += end;
      if (at + 1 < n[axis]) continue;
      faces.sink[s.at + i] += end;
      b[s.at + i] = end * length;
    }
  });
  const double energy = length * sum_of(b, work);  // if all voxels but the last were at zero
  Multigrid system(m.levels, std::move(faces), Cycle::W, work.quiet());
  keep_worst(out, solve(system, b, energy, x, accuracy, work));
  // From the energy, whose error is the square of that of x.
  const double ends = sum_over(m.cells(), work, [&](const Segment& s, int i, int z) {
    const double at = x[s.at + i], end = m.to_end(s.at + i, axis);
    double sum = 0;
    if (coordinate(s, i, z, axis) == 0) sum += end * at * at;
    if (coordinate(s, i, z, axis) + 1 == n[axis]) sum += end * std::pow(length - at, 2);
    return sum;
  });
  out.effective(axis, axis) = (energy_of(system, x, axis, 0, work) + ends) /
                              (static_cast<double>(m.box.count()) * step * step * m.weight[axis]);
  if (!out.potential.empty()) return;
  out.flow = of_voxels(m.cells(), flow_of(m, system, x, axis, 0, length, work), work);
  each_segment(m.cells(), work, [&](const Segment& s, int z) {
    for (int i = 0; i < s.length; ++i) x[s.at + i] -= (coordinate(s, i, z, axis) + 0.5) * step;
  });
  out.potential = of_voxels(m.cells(), x, work);
}

double largest_of(const PhaseMap& map, const std::vector<double>& values) {
  double out = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (map.fraction[i] > 0) out = std::max(out, values[i]);
  return out;
}

// Of each voxel: its phase here and at half the resolution, whether it is open, potential and flow. Of each
// cell: k, five vectors and a half of doubles, and the system.
double conduction_bytes(const VoxelBox& box, const std::vector<Cells>& levels) {
  double out = 11.0 * box.count() + 52.0 * levels.front().length() + Multigrid::bytes(levels, !box.periodic);
  for (const Cells& cells : levels) out += cells.bytes();
  return out;
}

// The cells that carry flow along one of the axes, with their conductivity relative to the largest one.
Model model_of(const PhaseMap& map, const std::vector<double>& values, const VoxelBox& box,
               const std::array<bool, 3>& axes, std::uint64_t memory, Solved& out, const Work& work) {
  require_memory(kLevelBytes * box.count(), memory, "the conductivity of the volume");
  std::vector<std::uint8_t> open(map.phase.size());
  each(open.size(), work, [&](std::size_t i) { open[i] = values[map.phase[i]] > 0; });
  Connected connected = connected_across(open, box, axes, work);
  open = {};
  for (int a = 0; a < 3; ++a)
    if (axes[a]) out.connected[a] = connected.along[a];
  Model m{box, {}, {}, (box.spacing.minCoeff() * box.spacing.cwiseInverse()).cwiseAbs2()};
  m.levels = std::make_shared<const std::vector<Cells>>(
      levels_of(box.size, {box.periodic, box.periodic, box.periodic}, connected.voxels, memory, work));
  require_memory(conduction_bytes(box, *m.levels), memory, "the conductivity of the volume");
  const double largest = largest_of(map, values);
  m.k.assign(m.cells().length(), 0);
  each_segment(m.cells(), work, [&](const Segment& s, int z) {
    const std::size_t voxel = m.cells().voxel(s, z);
    for (int i = 0; i < s.length; ++i) m.k[s.at + i] = values[map.phase[voxel + i]] / largest;
  });
  return m;
}

}  // namespace

Solved conduct(const PhaseMap& map, const std::vector<double>& values, Boundary boundary,
               const std::array<bool, 3>& directions, const Accuracy& accuracy, std::uint64_t memory,
               const Work& work) {
  VoxelBox box = map.box;
  box.periodic = boundary == Boundary::Periodic;
  const int count = directions[0] + directions[1] + directions[2];
  Solved out;
  std::optional<Model> model;
  std::optional<Multigrid> system;  // of a periodic box: the same for all directions
  for (int a = 0, done = 0; a < 3; ++a) {
    if (!directions[a]) continue;
    const Work part = work.part(static_cast<double>(done) / count, (done + 1.0) / count);
    ++done;
    if (!box.periodic) {
      model.reset();
      model = model_of(map, values, box, {a == 0, a == 1, a == 2}, memory, out, part.quiet());
      if (out.connected[a]) solve_fixed(*model, a, accuracy, out, part);
      continue;
    }
    if (!model) {
      model = model_of(map, values, box, {true, true, true}, memory, out, part.quiet());
      system.emplace(model->levels, faces_of(*model, part), Cycle::W, part.quiet());
    }
    if (out.connected[a]) solve_periodic(*model, *system, a, accuracy, out, part);
  }
  const double largest = largest_of(map, values);
  out.effective *= largest;
  for (float& v : out.flow) v *= static_cast<float>(largest);
  return out;
}

}  // namespace terrazzo::homogenize
