#include "nodes/properties/homogenize/conduction.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/properties/homogenize/connected.h"
#include "nodes/properties/homogenize/multigrid.h"
#include "nodes/properties/homogenize/vectors.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

int next(int i, int n) { return i + 1 == n ? 0 : i + 1; }

// Calls visit(voxel, next voxel along the axis, whether that is the first one again) for every voxel of
// planes z.
template <class Visit>
void each_face(const Vec3i& n, int axis, int begin, int end, const Work& work, Visit&& visit) {
  for (int z = begin; z < end; ++z) {
    work.check();
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x) {
        Vec3i to(x, y, z);
        to[axis] = next(to[axis], n[axis]);
        visit(voxel_at(x, y, z, n), voxel_at(to.x(), to.y(), to.z(), n), to[axis] == 0);
      }
  }
}

// One conduction problem in a box: the conductivity of each voxel, and how much a face of each axis counts.
struct Model {
  const VoxelBox& box;
  std::vector<float> k;  // of each voxel, 0 where nothing flows
  Vec3 weight;           // of faces: (shortest edge / edge along the axis)²

  // Of the face between two voxels, of which both conduct half of the way.
  float conductance(std::size_t i, std::size_t j, int axis) const {
    const float a = k[i], b = k[j];
    return a > 0 && b > 0 ? static_cast<float>(weight[axis] * 2 / (1.0 / a + 1.0 / b)) : 0;
  }
};

Conductances faces_of(const Model& m, bool wraps, const Work& work) {
  Conductances out;
  const Vec3i& n = m.box.size;
  out.size = n;
  for (int a = 0; a < 3; ++a) {
    out.face[a].resize(m.k.size());
    work.quiet().parallel(n.z(), 4, [&](std::size_t begin, std::size_t end) {
      each_face(n, a, begin, end, work, [&](std::size_t i, std::size_t j, bool around) {
        out.face[a][i] = around && !wraps ? 0 : m.conductance(i, j, a);
      });
    });
  }
  return out;
}

// A sum over all faces of an axis, of value(voxel, next voxel, whether that is the first one again).
template <class Value>
double sum_of_faces(const Vec3i& n, int axis, const Work& work, Value&& value) {
  return work.quiet().reduce<double>(
      n.z(), 4, 0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        each_face(n, axis, begin, end, work,
                  [&](std::size_t i, std::size_t j, bool around) { sum += value(i, j, around); });
        return sum;
      },
      [](double a, double b) { return a + b; });
}

// Flow at the centers of voxels: the mean of both faces of each axis. `step`: the mean slope times the edge,
// if it is not part of x. `length`: between the faces with fixed values 0 and `length`; 0: periodic.
std::vector<float> flow_of(const Model& m, const std::vector<double>& x, int axis, double step, double length,
                           const Work& work) {
  std::vector<float> out(m.k.size(), 0), at(m.k.size());
  for (int a = 0; a < 3; ++a) {
    std::fill(at.begin(), at.end(), 0);
    const double edge = m.box.spacing[a];
    each_face(m.box.size, a, 0, m.box.size.z(), work, [&](std::size_t i, std::size_t j, bool around) {
      if (around && length > 0) {
        if (a != axis) return;
        at[i] += static_cast<float>(m.k[i] * (length - x[i]) / edge);
        at[j] += static_cast<float>(m.k[j] * x[j] / edge);
        return;
      }
      const double slope = x[j] - x[i] + (a == axis ? step : 0);
      const float half = 0.5 * m.conductance(i, j, a) / m.weight[a] * slope / edge;
      at[i] += half;
      at[j] += half;
    });
    each(out.size(), work, [&](std::size_t i) { out[i] += at[i] * at[i]; });
  }
  each(out.size(), work, [&](std::size_t i) { out[i] = std::sqrt(out[i]); });
  return out;
}

void keep_worst(Solved& all, const Convergence& one) {
  all.iterations = std::max(all.iterations, one.iterations);
  all.residual = std::max(all.residual, one.residual);
}

// T = slope · position + x, with a periodic x.
void solve_periodic(const Model& m, Multigrid& system, int axis, const Accuracy& accuracy, Solved& out,
                    const Work& work) {
  const Vec3i& n = m.box.size;
  const double step = m.box.spacing[axis];
  std::vector<double> b(m.k.size(), 0), x;
  double energy = 0;  // of a uniform slope
  each_face(n, axis, 0, n.z(), work, [&](std::size_t i, std::size_t j, bool) {
    const double g = step * m.conductance(i, j, axis);
    b[i] += g;
    b[j] -= g;
    energy += step * g;
  });
  keep_worst(out, solve(system, b, energy, x, accuracy, work));
  // The diagonal from the energy, whose error is the square of that of x.
  double least = 0;
  for (int a = 0; a < 3; ++a) {
    const double mean = a == axis ? step : 0;
    double flow = 0;
    least += sum_of_faces(n, a, work, [&](std::size_t i, std::size_t j, bool) {
      return m.conductance(i, j, a) * std::pow(x[j] - x[i] + mean, 2);
    });
    if (a != axis)
      flow = sum_of_faces(n, a, work, [&](std::size_t i, std::size_t j, bool) {
        return m.conductance(i, j, a) / m.weight[a] * (x[j] - x[i]) / m.box.spacing[a];
      });
    out.effective(a, axis) = flow / m.k.size();
  }
  out.effective(axis, axis) = least / (m.k.size() * step * step * m.weight[axis]);
  if (!out.potential.empty()) return;
  out.potential.assign(x.begin(), x.end());
  out.flow = flow_of(m, x, axis, step, 0, work);
}

// T = 0 at the lower face and the length at the upper one, so that the mean slope is 1.
void solve_fixed(const Model& m, int axis, const Accuracy& accuracy, Solved& out, const Work& work) {
  const Vec3i& n = m.box.size;
  const double length = n[axis] * m.box.spacing[axis];
  Conductances faces = faces_of(m, false, work);
  faces.sink.assign(m.k.size(), 0);
  std::vector<double> b(m.k.size(), 0), x;
  double energy = 0;  // if all voxels but the last were at zero
  // The last voxel's next one is the first.
  each_face(n, axis, 0, n.z(), work, [&](std::size_t last, std::size_t first, bool around) {
    if (!around) return;
    const float low = 2 * m.k[first] * m.weight[axis];
    const float high = 2 * m.k[last] * m.weight[axis];
    faces.sink[first] += low;
    faces.sink[last] += high;
    b[last] += high * length;
    energy += high * length * length;
  });
  Multigrid system(std::move(faces), work.quiet());
  keep_worst(out, solve(system, b, energy, x, accuracy, work));
  // From the energy, whose error is the square of that of x.
  double least = 0;
  for (int a = 0; a < 3; ++a)
    least += sum_of_faces(n, a, work, [&](std::size_t i, std::size_t j, bool around) {
      if (!around) return m.conductance(i, j, a) * std::pow(x[j] - x[i], 2);
      if (a != axis) return 0.0;
      return 2 * m.weight[axis] * (m.k[j] * x[j] * x[j] + m.k[i] * std::pow(length - x[i], 2));
    });
  const double step = m.box.spacing[axis];
  out.effective(axis, axis) = least / (m.k.size() * step * step * m.weight[axis]);
  if (!out.potential.empty()) return;
  out.flow = flow_of(m, x, axis, 0, length, work);
  out.potential.resize(x.size());
  each(x.size(), work, [&](std::size_t i) {
    const std::size_t stride = axis == 0 ? 1 : axis == 1 ? n.x() : pixels_in(n.x(), n.y());
    const double at = (i / stride % n[axis] + 0.5) * m.box.spacing[axis];
    out.potential[i] = m.k[i] > 0 ? static_cast<float>(x[i] - at) : 0;
  });
}

// The voxels that carry flow, with their conductivity relative to the largest one.
std::vector<float> conducting(const PhaseMap& map, const VoxelBox& box, const std::vector<double>& values,
                              double largest, const std::array<bool, 3>& axes, Solved& out,
                              const Work& work) {
  std::vector<std::uint8_t> open(map.phase.size());
  each(open.size(), work, [&](std::size_t i) { open[i] = values[map.phase[i]] > 0; });
  const Connected connected = connected_across(open, box, axes, work);
  for (int a = 0; a < 3; ++a)
    if (axes[a]) out.connected[a] = connected.along[a];
  std::vector<float> k(open.size(), 0);
  each(k.size(), work, [&](std::size_t i) {
    if (connected.voxels[i]) k[i] = values[map.phase[i]] / largest;
  });
  return k;
}

}  // namespace

// The phases here and at half the resolution, k, five vectors and a half of doubles, potential and flow.
double conduction_bytes(const Vec3i& size) {
  return voxels_in(size) * (2 + 4 + 5 * 8 + 4 + 8.0) + Multigrid::bytes(size);
}

Solved conduct(const PhaseMap& map, const std::vector<double>& values, Boundary boundary,
               const std::array<bool, 3>& directions, const Accuracy& accuracy, std::uint64_t memory,
               const Work& work) {
  require_memory(conduction_bytes(map.box.size), memory, "the conductivity of the volume");
  VoxelBox box = map.box;
  box.periodic = boundary == Boundary::Periodic;
  double largest = 0;  // of the phases that occur
  for (std::size_t i = 0; i < values.size(); ++i)
    if (map.fraction[i] > 0) largest = std::max(largest, values[i]);
  const double shortest = box.spacing.minCoeff();
  const Vec3 weight = (shortest * box.spacing.cwiseInverse()).cwiseAbs2();
  const int count = directions[0] + directions[1] + directions[2];
  Solved out;
  int done = 0;
  const auto part = [&] { return work.part(static_cast<double>(done) / count, (done + 1.0) / count); };
  if (boundary == Boundary::Periodic) {
    const Model model{box, conducting(map, box, values, largest, {true, true, true}, out, work.quiet()),
                      weight};
    Multigrid system(faces_of(model, true, work), work.quiet());
    for (int a = 0; a < 3; ++a) {
      if (!directions[a]) continue;
      if (out.connected[a]) solve_periodic(model, system, a, accuracy, out, part());
      ++done;
    }
  } else {
    for (int a = 0; a < 3; ++a) {
      if (!directions[a]) continue;
      std::array<bool, 3> axis{};
      axis[a] = true;
      const Model model{box, conducting(map, box, values, largest, axis, out, work.quiet()), weight};
      if (out.connected[a]) solve_fixed(model, a, accuracy, out, part());
      ++done;
    }
  }
  out.effective *= largest;
  for (float& v : out.flow) v *= static_cast<float>(largest);
  return out;
}

}  // namespace terrazzo::homogenize
