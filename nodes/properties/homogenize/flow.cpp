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

// The Stokes equations of a periodic box, with lengths in units of the shortest edge of a voxel.
class Stokes {
 public:
  Stokes(const VoxelBox& box, std::vector<std::uint8_t> open, const Work& work)
      : n_(box.size), open_(std::move(open)), scale_(box.spacing.minCoeff() * box.spacing.cwiseInverse()) {
    for (int a = 0; a < 3; ++a) {
      active_[a].resize(open_.size());
      for_rows(
          [&](int y, int z) {
            for (int x = 0; x < n_.x(); ++x) {
              const std::size_t i = voxel_at(x, y, z, n_);
              active_[a][i] = open_[i] && open_[moved({x, y, z}, a, 1)];
            }
          },
          work);
    }
    for (int a = 0; a < 3; ++a) velocity_[a] = std::make_unique<Multigrid>(viscous(a, work), work.quiet());
    Conductances darcy;
    darcy.size = n_;
    for (int a = 0; a < 3; ++a) darcy.face[a] = free_velocity(a, work);
    pressure_ = std::make_unique<Multigrid>(std::move(darcy), work.quiet());
  }

  std::size_t count() const { return open_.size(); }
  const std::vector<std::uint8_t>& active(int axis) const { return active_[axis]; }

  // out = (−Δu + ∇p, −∇·u)
  void apply(const Fields<float>& x, Fields<double>& out, const Work& work) const {
    for (int a = 0; a < 3; ++a) velocity_[a]->apply(x[a], out[a], work);
    for_rows(
        [&](int y, int z) {
          for (int i = 0; i < n_.x(); ++i) {
            const std::size_t at = voxel_at(i, y, z, n_);
            double divergence = 0;
            for (int a = 0; a < 3; ++a) {
              if (active_[a][at])
                out[a][at] += scale_[a] *
                              (static_cast<double>(x[kPressure][moved({i, y, z}, a, 1)]) - x[kPressure][at]);
              divergence += scale_[a] * (static_cast<double>(x[a][at]) - x[a][moved({i, y, z}, a, -1)]);
            }
            out[kPressure][at] = open_[at] ? -divergence : 0;
          }
        },
        work);
  }

  void precondition(const Fields<double>& r, Fields<float>& z, const Work& work) const {
    for (int a = 0; a < 3; ++a) velocity_[a]->precondition(r[a], z[a], work);
    pressure_->precondition(r[kPressure], z[kPressure], work);
    each(count(), work, [&](std::size_t i) { z[kPressure][i] += static_cast<float>(r[kPressure][i]); });
  }

 private:
  template <class Row>
  void for_rows(Row&& row, const Work& work) const {
    work.quiet().parallel(n_.z(), 2, [&](std::size_t begin, std::size_t end) {
      for (int z = begin, stop = end; z < stop; ++z)
        for (int y = 0; y < n_.y(); ++y) row(y, z);
    });
  }

  std::size_t moved(Vec3i at, int axis, int by) const {
    at[axis] += by;
    if (at[axis] == n_[axis]) at[axis] = 0;
    if (at[axis] < 0) at[axis] = n_[axis] - 1;
    return voxel_at(at.x(), at.y(), at.z(), n_);
  }

  // −Δ of the velocity along an axis. The next velocity along another axis lies between two voxels: if both
  // are walls, the wall is only half an edge away.
  Conductances viscous(int axis, const Work& work) const {
    Conductances out;
    out.size = n_;
    for (auto& f : out.face) f.assign(count(), 0);
    out.sink.assign(count(), 0);
    for_rows(
        [&](int y, int z) {
          for (int x = 0; x < n_.x(); ++x) {
            const Vec3i at(x, y, z);
            const std::size_t i = voxel_at(x, y, z, n_);
            if (!active_[axis][i]) continue;
            for (int b = 0; b < 3; ++b)
              for (const int by : {-1, 1}) {
                const std::size_t j = moved(at, b, by);
                const float weight = scale_[b] * scale_[b];
                if (active_[axis][j]) {
                  if (by == 1) out.face[b][i] = weight;
                  continue;
                }
                Vec3i beside = at;
                beside[axis] = beside[axis] + 1 == n_[axis] ? 0 : beside[axis] + 1;
                const bool walls = b != axis && !open_[j] && !open_[moved(beside, b, by)];
                out.sink[i] += (walls ? 2 : 1) * weight;
              }
          }
        },
        work);
    return out;
  }

  // The velocity along an axis, in the pores, of a fluid that may have sources: a local permeability.
  std::vector<float> free_velocity(int axis, const Work& work) const {
    std::vector<double> b(count()), x;
    each(count(), work, [&](std::size_t i) { b[i] = active_[axis][i]; });
    solve(*velocity_[axis], b, 0, x, {kRough, kManyTimes}, work.quiet());
    std::vector<float> out(count());
    each(count(), work, [&](std::size_t i) {
      out[i] = active_[axis][i] ? static_cast<float>(std::max(0.0, x[i]) * scale_[axis] * scale_[axis]) : 0;
    });
    return out;
  }

  Vec3i n_;
  std::vector<std::uint8_t> open_, active_[3];
  Vec3 scale_;  // shortest edge / edge
  std::unique_ptr<Multigrid> velocity_[3], pressure_;
};

// Minimizes the residual over growing Krylov spaces (Paige and Saunders 1975; Elman, Silvester and Wathen
// 2014, algorithm 4.1).
Convergence minres(const Stokes& system, const Fields<double>& b, Fields<float>& x, const Accuracy& accuracy,
                   const Work& work) {
  const std::size_t n = system.count();
  Fields<double> before = zero_fields<double>(n), v = b, next = zero_fields<double>(n);
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
std::vector<float> speed_of(const Fields<float>& x, const Vec3i& n, const Work& work) {
  std::vector<float> out(voxels_in(n));
  const std::size_t step[3] = {1, static_cast<std::size_t>(n.x()), pixels_in(n.x(), n.y())};
  each(out.size(), work, [&](std::size_t i) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
      const bool first = i / step[a] % n[a] == 0;
      const std::size_t behind = first ? i + (n[a] - 1) * step[a] : i - step[a];
      sum += std::pow(0.5 * (static_cast<double>(x[a][i]) + x[a][behind]), 2);
    }
    out[i] = std::sqrt(sum);
  });
  return out;
}

// The voxels and their mirror image along an axis, with a wall around the others, in a periodic box. By
// symmetry, the pressure is constant on both mirrors, and the velocity is normal to them.
struct Mirrored {
  VoxelBox box;
  std::vector<std::uint8_t> open;
};

Vec3i mirrored_size(const Vec3i& size, int axis) {
  Vec3i out = size + Vec3i::Ones();
  out[axis] = 2 * size[axis];
  return out;
}

Mirrored mirrored(const VoxelBox& box, const std::vector<std::uint8_t>& open, int axis, const Work& work) {
  Mirrored out;
  out.box = box;
  out.box.periodic = true;
  out.box.size = mirrored_size(box.size, axis);
  const Vec3i& n = out.box.size;
  out.open.assign(voxels_in(n), 0);
  for (int z = 0; z < n.z(); ++z) {
    work.check();
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x) {
        Vec3i at(x, y, z);
        if (at[axis] >= box.size[axis]) at[axis] = n[axis] - 1 - at[axis];
        if ((at.array() < box.size.array()).all())
          out.open[voxel_at(x, y, z, n)] = open[voxel_at(at.x(), at.y(), at.z(), box.size)];
      }
  }
  return out;
}

template <class T>
std::vector<T> cropped(const std::vector<T>& values, const Vec3i& from, const Vec3i& to) {
  std::vector<T> out(voxels_in(to));
  for (int z = 0; z < to.z(); ++z)
    for (int y = 0; y < to.y(); ++y)
      for (int x = 0; x < to.x(); ++x) out[voxel_at(x, y, z, to)] = values[voxel_at(x, y, z, from)];
  return out;
}

// `size`: of the volume without its mirror image and walls; velocities are means over it.
void solve_axis(const Stokes& system, const VoxelBox& box, const Vec3i& size, int axis,
                const Accuracy& accuracy, Solved& out, const Work& work) {
  Fields<double> b = zero_fields<double>(system.count());
  each(system.count(), work, [&](std::size_t i) { b[axis][i] = system.active(axis)[i]; });
  Fields<float> x = zero_fields<float>(system.count());
  const Convergence c = minres(system, b, x, accuracy, work);
  out.iterations = std::max(out.iterations, c.iterations);
  out.residual = std::max(out.residual, c.residual);
  const double unit = std::pow(box.spacing.minCoeff(), 2);
  const double counted = static_cast<double>(voxels_in(size)) * box.size[axis] / size[axis];
  for (int a = 0; a < 3; ++a) {
    if (box.size != size && a != axis) continue;
    out.effective(a, axis) = unit * sum_of(x[a], work) / counted;
  }
  if (!out.potential.empty()) return;
  out.flow = cropped(speed_of(x, box.size, work), box.size, size);
  out.potential = cropped(x[kPressure], box.size, size);
  for (float& v : out.flow) v *= static_cast<float>(unit);
  for (float& v : out.potential) v *= static_cast<float>(box.spacing.minCoeff());
}

}  // namespace

double flow_bytes(const Vec3i& size) {
  // Three fields of doubles and five of floats; the operators; masks, potential and flow.
  return voxels_in(size) * (4 * (4 * 8 + 5 * 4) + 8 + 16.0) +
         4 * (Multigrid::bytes(size) + 4.0 * voxels_in(size));
}

Solved permeate(const PhaseMap& map, const std::vector<char>& open, Boundary boundary,
                const std::array<bool, 3>& directions, const Accuracy& accuracy, std::uint64_t memory,
                const Work& work) {
  double bytes = 0;
  for (int a = 0; a < 3; ++a)
    if (directions[a])
      bytes = std::max(
          bytes, flow_bytes(boundary == Boundary::Fixed ? mirrored_size(map.box.size, a) : map.box.size));
  require_memory(bytes, memory, "the flow through the volume");
  std::vector<std::uint8_t> pores(map.phase.size());
  each(pores.size(), work, [&](std::size_t i) { pores[i] = open[map.phase[i]]; });
  VoxelBox box = map.box;
  box.periodic = boundary == Boundary::Periodic;
  Solved out;
  const int count = directions[0] + directions[1] + directions[2];
  int done = 0;
  std::unique_ptr<Stokes> shared;
  for (int a = 0; a < 3; ++a) {
    if (!directions[a]) continue;
    const Work part = work.part(static_cast<double>(done) / count, (done + 1.0) / count);
    ++done;
    std::array<bool, 3> axes{true, true, true};
    if (!box.periodic) {
      axes = {};
      axes[a] = true;
    }
    if (!shared || !box.periodic) {
      Connected connected = connected_across(pores, box, axes, work.quiet());
      out.connected[a] = connected.along[a];
      if (box.periodic) {
        out.connected = connected.along;
        shared = std::make_unique<Stokes>(box, std::move(connected.voxels), work.quiet());
      } else if (out.connected[a]) {
        const Mirrored m = mirrored(box, connected.voxels, a, part);
        solve_axis(Stokes(m.box, m.open, work.quiet()), m.box, box.size, a, accuracy, out, part);
      }
    }
    if (box.periodic && out.connected[a]) solve_axis(*shared, box, box.size, a, accuracy, out, part);
  }
  return out;
}

}  // namespace terrazzo::homogenize
