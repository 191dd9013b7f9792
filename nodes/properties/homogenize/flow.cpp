#include "nodes/properties/homogenize/flow.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "nodes/data/indices.h"
#include "nodes/properties/homogenize/connected.h"
#include "nodes/properties/homogenize/multigrid.h"
#include "nodes/properties/homogenize/vectors.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

// Velocities along x, y and z on the faces between a voxel and the next one, and pressures in voxels.
template <class T>
using Fields = std::array<std::vector<T>, 4>;
constexpr int kPressure = 3;

// Of the solution that only serves as a preconditioner. The equations of −Δ with walls converge in some ten
// steps.
constexpr double kRough = 0.01;
// Of the pressure's error after one step of its preconditioner. A smaller rest costs more cycles than it
// saves steps.
constexpr double kPressureRest = 0.5;
constexpr int kManyTimes = 100'000;

template <class T>
Fields<T> zero_fields(std::size_t n) {
  Fields<T> out;
  for (auto& f : out) f.assign(n, 0);
  return out;
}

template <class A, class B>
double dot(const Fields<A>& a, const Fields<B>& b, const Work& work) {
  double sum = 0;
  for (int c = 0; c < 4; ++c) sum += homogenize::dot(a[c], b[c], work);
  return sum;
}

// The pores of a box. With a given pressure at both ends of an axis, the box has one more layer of voxels
// before the first one: the velocities through the lower end lie in it, and nothing else does.
struct Pores {
  VoxelBox box;
  int axis = -1;                    // with given pressures; −1: periodic
  std::vector<std::uint8_t> fluid;  // 1 in the pores, 0 in the layer

  bool at(Vec3i v) const {
    for (int a = 0; a < 3; ++a) {
      if (box.periodic) v[a] = (v[a] + box.size[a]) % box.size[a];
      if (v[a] < 0 || v[a] >= box.size[a]) return false;
    }
    return fluid[voxel_at(v.x(), v.y(), v.z(), box.size)] != 0;
  }
};

// The Stokes equations, with lengths in units of the shortest edge of a voxel. At an end with a given
// pressure, the flow continues as its mirror image: the velocities through the end count half, as half of
// their surroundings is outside, and the others are zero there.
class Stokes {
 public:
  Stokes(const Pores& pores, std::uint64_t memory, const Work& work)
      : axis_(pores.axis), scale_(pores.box.spacing.minCoeff() * pores.box.spacing.cwiseInverse()) {
    const bool wraps = pores.box.periodic;
    levels_ = std::make_shared<const std::vector<Cells>>(
        levels_of(pores.box.size, {wraps, wraps, wraps}, open_voxels(pores), memory, work));
    require_memory(bytes(pores.box), memory, "the flow through the volume");
    for (int a = 0; a < 3; ++a) find_active(a, work);
    for (int a = 0; a < 3; ++a)
      velocity_[a] = std::make_unique<Multigrid>(levels_, viscous(pores, a, work), Cycle::V, work.quiet());
    pressure_ = std::make_unique<Polynomial>(
        std::make_unique<Multigrid>(levels_, darcy(work), Cycle::W, work.quiet()), kPressureRest, work);
  }

  const Cells& cells() const { return levels_->front(); }
  std::size_t count() const { return cells().length(); }
  int axis() const { return axis_; }
  // How much of the surroundings of the velocity toward the next cell is inside: 0 if the next voxel is a
  // wall.
  double inside(int axis, std::size_t cell) const { return 0.5 * halves_[axis][cell]; }

  // out = (−Δu + ∇p, −∇·u)
  void apply(const Fields<float>& x, Fields<double>& out, const Work& work) const {
    for (int a = 0; a < 3; ++a) velocity_[a]->apply(x[a], out[a], work);
    const std::vector<float>& p = x[kPressure];
    each_segment(cells(), work, [&](const Segment& s, int z) {
      for (int i = 0; i < s.length; ++i) {
        const std::size_t at = s.at + i;
        double divergence = 0;
        for (int a = 0; a < 3; ++a) {
          if (halves_[a][at]) out[a][at] += scale_[a] * (static_cast<double>(p[s.next(a, i)]) - p[at]);
          divergence += scale_[a] * (static_cast<double>(x[a][at]) - x[a][s.previous(a, i)]);
        }
        out[kPressure][at] = in_layer(s, i, z) ? 0 : -divergence;
      }
    });
  }

  void precondition(const Fields<double>& r, Fields<float>& z, const Work& work) const {
    for (int a = 0; a < 3; ++a) velocity_[a]->precondition(r[a], z[a], work);
    pressure_->precondition(r[kPressure], z[kPressure], work);
    each(count(), work, [&](std::size_t i) { z[kPressure][i] += static_cast<float>(r[kPressure][i]); });
  }

 private:
  bool in_layer(const Segment& s, int i, int z) const {
    return axis_ >= 0 && coordinate(s, i, z, axis_) == 0;
  }
  bool at_end(const Segment& s, int i, int z) const {
    return axis_ >= 0 && coordinate(s, i, z, axis_) + 1 == cells().size()[axis_];
  }

  // The pores, and the layer before those of the first voxels.
  static std::vector<std::uint8_t> open_voxels(const Pores& pores) {
    std::vector<std::uint8_t> out = pores.fluid;
    if (pores.axis < 0) return out;
    const Vec3i& n = pores.box.size;
    Vec3i layer = n;
    layer[pores.axis] = 1;
    for (int z = 0; z < layer.z(); ++z)
      for (int y = 0; y < layer.y(); ++y)
        for (int x = 0; x < layer.x(); ++x)
          out[voxel_at(x, y, z, n)] = pores.at(Vec3i(x, y, z) + Vec3i::Unit(pores.axis));
    return out;
  }

  // Of each voxel: its phase here and at half the resolution, whether it is a pore (in the whole, connected
  // and in the box), pressure and speed. Of each cell: three fields of doubles and five of floats, and the
  // operators.
  double bytes(const VoxelBox& box) const {
    double out = 13.0 * box.count() + (4 * (3 * 8 + 5 * 4) + 3.0) * count() +
                 3 * Multigrid::bytes(*levels_, true) + Multigrid::bytes(*levels_, axis_ >= 0) +
                 Polynomial::bytes(*levels_);
    for (const Cells& cells : *levels_) out += cells.bytes();
    return out;
  }

  void find_active(int axis, const Work& work) {
    halves_[axis].assign(count(), 0);
    each_segment(cells(), work, [&](const Segment& s, int z) {
      for (int i = 0; i < s.length; ++i) {
        const bool through = axis == axis_ && (in_layer(s, i, z) || at_end(s, i, z));
        const bool along = s.next(axis, i) >= cells().first() && (axis == axis_ || !in_layer(s, i, z));
        halves_[axis][s.at + i] = through ? 1 : along ? 2 : 0;
      }
    });
  }

  // −Δ of the velocity along an axis. The next velocity along another axis lies between two voxels: if both
  // are walls, the wall is only half an edge away.
  Conductances viscous(const Pores& pores, int axis, const Work& work) const {
    Conductances out;
    for (auto& f : out.face) f.assign(count(), 0);
    out.sink.assign(count(), 0);
    const std::vector<std::uint8_t>& halves = halves_[axis];
    each_segment(cells(), work, [&](const Segment& s, int z) {
      for (int i = 0; i < s.length; ++i) {
        const std::size_t cell = s.at + i;
        const Vec3i at(s.x + i, s.y, z);
        if (halves[cell] == 0) continue;
        for (int b = 0; b < 3; ++b) {
          const float weight =
              static_cast<float>(scale_[b] * scale_[b]) * (b == axis ? 1.0F : 0.5F * halves[cell]);
          for (const int by : {-1, 1}) {
            if (halves[by == 1 ? s.next(b, i) : s.previous(b, i)] > 0) {
              if (by == 1) out.face[b][cell] = weight;
              continue;
            }
            const bool mirrored =
                b == axis && axis == axis_ && (by == 1 ? at_end(s, i, z) : in_layer(s, i, z));
            if (mirrored) continue;
            const Vec3i beside = at + by * Vec3i::Unit(b);
            const bool walls = b != axis && !pores.at(beside) && !pores.at(beside + Vec3i::Unit(axis));
            out.sink[cell] += (walls ? 2 : 1) * weight;
          }
        }
      }
    });
    return out;
  }

  // The velocity along an axis, in the pores, of a fluid that may have sources: a local permeability.
  std::vector<double> free_velocity(int axis, const Work& work) const {
    std::vector<double> b(count()), x;
    each(count(), work, [&](std::size_t i) { b[i] = inside(axis, i); });
    solve(*velocity_[axis], b, 0, x, {kRough, kManyTimes}, work.quiet());
    each(count(), work, [&](std::size_t i) { x[i] = std::max(0.0, x[i]) * scale_[axis] * scale_[axis]; });
    return x;
  }

  // Darcy's law in the pores. A given pressure lies at the end of an axis, half an edge away.
  Conductances darcy(const Work& work) const {
    Conductances out;
    if (axis_ >= 0) out.sink.assign(count(), 0);
    for (int a = 0; a < 3; ++a) {
      const std::vector<double> local = free_velocity(a, work);
      out.face[a].assign(count(), 0);
      each_segment(cells(), work, [&](const Segment& s, int z) {
        for (int i = 0; i < s.length; ++i) {
          const std::size_t cell = s.at + i, before = s.previous(a, i);
          if (halves_[a][cell] == 2) out.face[a][cell] = static_cast<float>(local[cell]);
          if (a != axis_ || in_layer(s, i, z)) continue;
          if (coordinate(s, i, z, a) == 1) out.sink[cell] += static_cast<float>(2 * local[before]);
          if (at_end(s, i, z)) out.sink[cell] += static_cast<float>(2 * local[cell]);
        }
      });
    }
    return out;
  }

  int axis_;
  Vec3 scale_;  // shortest edge / edge
  std::shared_ptr<const std::vector<Cells>> levels_;
  std::vector<std::uint8_t> halves_[3];  // twice inside()
  std::unique_ptr<Multigrid> velocity_[3];
  std::unique_ptr<Polynomial> pressure_;
};

// Solves system · x = v: minimizes the residual over growing Krylov spaces (Paige and Saunders 1975; Elman,
// Silvester and Wathen 2014, algorithm 4.1).
Convergence minres(const Stokes& system, Fields<double> v, Fields<float>& x, const Accuracy& accuracy,
                   const Work& work) {
  const std::size_t n = system.count();
  Fields<double> before = zero_fields<double>(n), next = zero_fields<double>(n);
  Fields<float> z = zero_fields<float>(n), fresh = zero_fields<float>(n), older = zero_fields<float>(n),
                old = zero_fields<float>(n);
  system.precondition(v, z, work);
  double gamma = std::sqrt(dot(v, z, work)), gamma_before = 1, eta = gamma;
  const double whole = gamma;
  double s_before = 0, s = 0, c_before = 1, c = 1;
  Convergence out;
  for (;; ++out.iterations) {
    out.residual = whole != 0 ? std::abs(eta / whole) : 0;
    report(out, accuracy.tolerance, work);
    if (out.residual <= accuracy.tolerance) return out;
    if (out.iterations == accuracy.iterations || !std::isfinite(out.residual))
      throw stalled(out, accuracy.tolerance);
    const float inverse = 1 / gamma;
    for (auto& f : z) each(n, work, [&](std::size_t i) { f[i] *= inverse; });
    system.apply(z, next, work);
    const double delta = dot(next, z, work), back = delta / gamma, further = gamma / gamma_before;
    for (int k = 0; k < 4; ++k)
      each(n, work, [&](std::size_t i) { next[k][i] -= back * v[k][i] + further * before[k][i]; });
    system.precondition(next, fresh, work);
    // NaN if rounding makes the square negative, which then is an error.
    const double gamma_next = std::sqrt(dot(next, fresh, work));
    const double a0 = c * delta - c_before * s * gamma, a1 = std::hypot(a0, gamma_next);
    const double a2 = s * delta + c_before * c * gamma, a3 = s_before * gamma;
    c_before = c;
    s_before = s;
    c = a0 / a1;
    s = gamma_next / a1;
    const double step = c * eta;
    for (int k = 0; k < 4; ++k)
      each(n, work, [&](std::size_t i) {
        const float w = (z[k][i] - a3 * older[k][i] - a2 * old[k][i]) / a1;
        older[k][i] = w;
        x[k][i] += static_cast<float>(step * w);
      });
    std::swap(older, old);
    std::swap(before, v);
    std::swap(v, next);
    std::swap(z, fresh);
    eta *= -s;
    gamma_before = gamma;
    gamma = gamma_next;
  }
}

// Speed at the centers of voxels.
std::vector<float> speed_of(const Cells& cells, const Fields<float>& x, const Work& work) {
  std::vector<float> out(cells.length(), 0);
  each_segment(cells, work, [&](const Segment& s, int) {
    for (int i = 0; i < s.length; ++i) {
      double sum = 0;
      for (int a = 0; a < 3; ++a)
        sum += std::pow(0.5 * (static_cast<double>(x[a][s.at + i]) + x[a][s.previous(a, i)]), 2);
      out[s.at + i] = static_cast<float>(std::sqrt(sum));
    }
  });
  return out;
}

Vec3i layer_before(int axis) { return axis < 0 ? Vec3i::Zero() : Vec3i(Vec3i::Unit(axis)); }

// The pores of a volume, with one more layer if an axis has given pressures at its ends.
Pores pores_of(const VoxelBox& box, const std::vector<std::uint8_t>& open, int axis, const Work& work) {
  Pores out{box, axis, {}};
  const Vec3i layer = layer_before(axis);
  out.box.size += layer;
  out.fluid.assign(out.box.count(), 0);
  const Vec3i& n = box.size;
  each_plane(n.z(), 1, work, [&](int z) {
    for (int y = 0; y < n.y(); ++y) {
      const std::uint8_t* row = &open[voxel_at(0, y, z, n)];
      std::copy(row, row + n.x(),
                &out.fluid[voxel_at(layer.x(), y + layer.y(), z + layer.z(), out.box.size)]);
    }
  });
  return out;
}

// Values of cells at the voxels of the volume, times a factor.
std::vector<float> of_volume(const Stokes& system, const std::vector<float>& values, double factor,
                             const Work& work) {
  std::vector<float> out = of_voxels(system.cells(), values, work);
  for (float& v : out) v *= static_cast<float>(factor);
  if (system.axis() < 0) return out;
  const Vec3i &n = system.cells().size(), layer = layer_before(system.axis()), m = n - layer;
  std::size_t to = 0;  // never behind what it is copied from
  for (int z = 0; z < m.z(); ++z)
    for (int y = 0; y < m.y(); ++y, to += m.x()) {
      const std::size_t from = voxel_at(layer.x(), y + layer.y(), z + layer.z(), n);
      std::copy(&out[from], &out[from] + m.x(), &out[to]);
    }
  out.resize(voxels_in(m));
  return out;
}

void solve_axis(const Stokes& system, const VoxelBox& box, int axis, const Accuracy& accuracy, Solved& out,
                const Work& work) {
  Fields<double> b = zero_fields<double>(system.count());
  each(system.count(), work, [&](std::size_t i) { b[axis][i] = system.inside(axis, i); });
  Fields<float> x = zero_fields<float>(system.count());
  const Convergence c = minres(system, std::move(b), x, accuracy, work);
  out.iterations = std::max(out.iterations, c.iterations);
  out.residual = std::max(out.residual, c.residual);
  const double shortest = box.spacing.minCoeff(), unit = shortest * shortest;
  for (int a = 0; a < 3; ++a) {
    if (!box.periodic && a != axis) continue;
    const double flow = sum_over(system.cells(), work, [&](const Segment& s, int i, int) {
      return system.inside(a, s.at + i) * x[a][s.at + i];
    });
    out.effective(a, axis) = unit * flow / static_cast<double>(box.count());
  }
  if (!out.potential.empty()) return;
  out.flow = of_volume(system, speed_of(system.cells(), x, work), unit, work);
  out.potential = of_volume(system, x[kPressure], shortest, work);
}

}  // namespace

Solved permeate(const PhaseMap& map, const std::vector<char>& open, Boundary boundary,
                const std::array<bool, 3>& directions, const Accuracy& accuracy, std::uint64_t memory,
                const Work& work) {
  for (int a = 0; a < 3; ++a) {
    if (!directions[a]) continue;
    const Vec3i layer = boundary == Boundary::Fixed ? layer_before(a) : Vec3i::Zero();
    require_memory(kLevelBytes * voxels_in(map.box.size + layer), memory, "the flow through the volume");
  }
  std::vector<std::uint8_t> pores(map.phase.size());
  each(pores.size(), work, [&](std::size_t i) { pores[i] = open[map.phase[i]]; });
  VoxelBox box = map.box;
  box.periodic = boundary == Boundary::Periodic;
  Solved out;
  const int count = directions[0] + directions[1] + directions[2];
  std::unique_ptr<Stokes> system;  // of a periodic box: the same for all directions
  for (int a = 0, done = 0; a < 3; ++a) {
    if (!directions[a]) continue;
    const Work part = work.part(static_cast<double>(done) / count, (done + 1.0) / count);
    ++done;
    if (!system || !box.periodic) {
      system.reset();
      const std::array<bool, 3> axes{box.periodic || a == 0, box.periodic || a == 1, box.periodic || a == 2};
      const Connected connected = connected_across(pores, box, axes, work.quiet());
      for (int k = 0; k < 3; ++k)
        if (axes[k]) out.connected[k] = connected.along[k];
      if (!out.connected[a] && !box.periodic) continue;
      system = std::make_unique<Stokes>(pores_of(box, connected.voxels, box.periodic ? -1 : a, work.quiet()),
                                        memory, work.quiet());
    }
    if (out.connected[a]) solve_axis(*system, box, a, accuracy, out, part);
  }
  return out;
}

}  // namespace terrazzo::homogenize
