// The iteration of relaxation.h for packings of only spheres: it needs an order of magnitude
// less memory and time.
#include <algorithm>
#include <cmath>

#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {
namespace {

constexpr double kSphereRidge = 0.1;
constexpr std::size_t kGrain = 512;

// Solves (m + kSphereRidge) x = r for symmetric m: xx xy xz yy yz zz.
Vec3 solve(const double* m, const Vec3& r) {
  const double a = m[0] + kSphereRidge, b = m[1], c = m[2], d = m[3] + kSphereRidge, e = m[4],
               f = m[5] + kSphereRidge;
  const double ca = d * f - e * e, cb = c * e - b * f, cc = b * e - c * d;
  const double det = a * ca + b * cb + c * cc;
  return Vec3(ca * r[0] + cb * r[1] + cc * r[2], cb * r[0] + (a * f - c * c) * r[1] + (b * c - a * e) * r[2],
              cc * r[0] + (b * c - a * e) * r[1] + (a * d - b * b) * r[2]) /
         det;
}

}  // namespace

void Relaxation::list_spheres() {
  const std::size_t n = packing_.count();
  first_neighbor_.assign(n + 1, 0);
  for (const auto& p : pairs_) {
    ++first_neighbor_[p.a + 1];
    ++first_neighbor_[p.b + 1];
  }
  for (std::size_t i = 0; i < n; ++i) first_neighbor_[i + 1] += first_neighbor_[i];
  neighbors_.resize(2 * pairs_.size());
  std::vector<std::int32_t> at(first_neighbor_.begin(), first_neighbor_.end() - 1);
  for (const auto& p : pairs_) {
    const int image = 13 + p.image[0] + 3 * p.image[1] + 9 * p.image[2];
    neighbors_[at[p.a]++] = {p.b, image};
    neighbors_[at[p.b]++] = {p.a, 26 - image};
  }
  pairs_ = {};
  radius_.resize(n);
  wish_.resize(n);
  for (std::size_t i = 0; i < n; ++i) radius_[i] = shapes_[packing_.shape[i]].ball * packing_.scale[i];
}

Overlap Relaxation::find_sphere_contacts(const Work& work) {
  Vec3 shift[27];
  for (int k = 0; k < 27; ++k)
    shift[k] = Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).cwiseProduct(packing_.box);
  Overlap none;
  none.worst = -1;
  const double allowance = 1e-6;  // relative to the radius, for rounding
  Overlap sum = work.reduce<Overlap>(
      packing_.count(), kGrain, none,
      [&](std::size_t begin, std::size_t end) {
        Overlap part = none;
        part.tests = first_neighbor_[end] - first_neighbor_[begin];
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3 p = packing_.position[i];
          const double radius = radius_[i], size = packing_.size[i];
          double m[6] = {}, deepest = 0;
          Vec3 side = Vec3::Zero();
          for (std::int32_t k = first_neighbor_[i]; k < first_neighbor_[i + 1]; ++k) {
            const Neighbor& near = neighbors_[k];
            const double smaller = std::min(size, packing_.size[near.other]);
            const double required = packing_.shrink * (1 + allowance) * (radius + radius_[near.other]) +
                                    binder_gap_ + extra.all * smaller;
            const double wanted = required + surplus * smaller;
            const Vec3 offset = packing_.position[near.other] + shift[near.image] - p;
            const double square = offset.squaredNorm();
            if (square >= wanted * wanted) continue;
            const double distance = std::sqrt(square);
            const Vec3 n = distance > 1e-12 ? Vec3(-offset / distance)
                                            : Vec3(static_cast<std::int32_t>(i) < near.other ? 1 : -1, 0, 0);
            const double depth = wanted - distance;
            m[0] += n[0] * n[0];
            m[1] += n[0] * n[1];
            m[2] += n[0] * n[2];
            m[3] += n[1] * n[1];
            m[4] += n[1] * n[2];
            m[5] += n[2] * n[2];
            side += depth * n;
            deepest = std::max(deepest, depth);
            const double relative = (required - distance) / (smaller * packing_.shrink);
            part.worst = std::max(part.worst, relative);
            ++part.touching;  // counts each pair twice
            if (relative > 0) {
              part.energy += relative * relative;
              ++part.pairs;
            }
          }
          strain_[i] = deepest / size;
          wish_[i] = deepest > 0 ? solve(m, side) : Vec3::Zero();
        }
        return part;
      },
      combined);
  sum.energy *= 0.5;
  sum.pairs /= 2;
  sum.touching /= 2;
  return sum;
}

void Relaxation::move_spheres(const Work& work) {
  const double farthest = work.reduce<double>(
      packing_.count(), kGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double far = 0;
        for (std::size_t i = begin; i < end; ++i) {
          Vec3& v = velocity_[i];
          const double limit = 0.1 * packing_.size[i];
          if (strain_[i] > 0) {
            const Vec3 step = step_length * wish_[i];
            v = v.dot(step) > 0 ? Vec3(step + memory * v) : step;
            if (v.squaredNorm() > limit * limit) v *= limit / v.norm();
          } else {
            v *= 0.5;
            if (v.norm() < 1e-4 * packing_.size[i]) v.setZero();
          }
          if (v.isZero(0)) continue;
          packing_.position[i] += v;
          drift_[i] += v;
          far = std::max(far, drift_[i].squaredNorm());
        }
        return far;
      },
      [](double x, double y) { return std::max(x, y); });
  end_move(std::sqrt(farthest));
}

}  // namespace terrazzo::packing
