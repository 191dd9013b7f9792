#include "nodes/properties/homogenize/elasticity.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "nodes/common/texture/block_fft.h"
#include "nodes/properties/homogenize/elements.h"
#include "nodes/properties/homogenize/vectors.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

using Complex = std::complex<float>;

constexpr double kRounding = 3e-7;  // of forces, where the largest modulus and strain are 1
constexpr double kDrift = 10;       // of the residual that is updated in single precision

PerLoad dot(const Displacements& a, const Displacements& b, const Work& work) {
  PerLoad sum{};
  for (int c = 0; c < 3; ++c) {
    const float *p = reinterpret_cast<const float*>(a[c].data()),
                *q = reinterpret_cast<const float*>(b[c].data());
    const PerLoad part = work.quiet().reduce<PerLoad>(
        a[c].size(), 1 << 15, {},
        [&](std::size_t begin, std::size_t end) {
          double first = 0, second = 0;
          for (std::size_t i = 2 * begin; i < 2 * end; i += 2) {
            first += static_cast<double>(p[i]) * q[i];
            second += static_cast<double>(p[i + 1]) * q[i + 1];
          }
          return PerLoad{first, second};
        },
        [](PerLoad x, const PerLoad& y) {
          return PerLoad{x[0] + y[0], x[1] + y[1]};
        });
    for (int l = 0; l < 2; ++l) sum[l] += part[l];
  }
  return sum;
}

// The inverse of the elements' operator in a homogeneous medium, which is a 3 × 3 matrix at each frequency.
class Reference {
 public:
  Reference(const Vec3i& size, double lambda, double mu) : size_(size), lambda_(lambda), mu_(mu) {
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < size[a]; ++i) {
        const double angle = 2 * M_PI * i / size[a];
        difference_[a].push_back(2 - 2 * std::cos(angle));
        mean_[a].push_back((2 + std::cos(angle)) / 3);
        slope_[a].push_back(std::sin(angle));
      }
  }

  void apply(Displacements& u, const Work& work) const {
    for (auto& c : u) transform_block(c, size_, false, work.quiet());
    const double scale = 1.0 / voxels_in(size_);  // of the transforms
    work.quiet().parallel(size_.z(), 2, [&](std::size_t begin, std::size_t end) {
      for (int z = begin, stop = end; z < stop; ++z)
        for (int y = 0; y < size_.y(); ++y)
          for (int x = 0; x < size_.x(); ++x) {
            const std::size_t i = voxel_at(x, y, z, size_);
            const Eigen::Matrix3f m = i == 0 ? Eigen::Matrix3f::Zero().eval()
                                             : (scale * symbol(x, y, z).inverse()).cast<float>().eval();
            const Eigen::Vector3cf v = m * Eigen::Vector3cf(u[0][i], u[1][i], u[2][i]);
            for (int c = 0; c < 3; ++c) u[c][i] = v[c];
          }
    });
    for (auto& c : u) transform_block(c, size_, true, work.quiet());
  }

 private:
  Mat3 symbol(int x, int y, int z) const {
    const int at[3] = {x, y, z};
    Vec3 s, m, d;
    for (int a = 0; a < 3; ++a) {
      s[a] = difference_[a][at[a]];
      m[a] = mean_[a][at[a]];
      d[a] = slope_[a][at[a]];
    }
    const Vec3 laplace(s[0] * m[1] * m[2], m[0] * s[1] * m[2], m[0] * m[1] * s[2]);
    Mat3 k;
    for (int a = 0; a < 3; ++a) {
      k(a, a) = (lambda_ + mu_) * laplace[a] + mu_ * laplace.sum();
      for (int b = 0; b < a; ++b) k(a, b) = k(b, a) = (lambda_ + mu_) * d[a] * d[b] * m[3 - a - b];
    }
    return k;
  }

  Vec3i size_;
  double lambda_, mu_;
  std::vector<double> difference_[3], mean_[3], slope_[3];
};

// The residual of two loads, whose forces for a uniform strain have the squares `whole`; 0: of rounding
// errors only.
double residual_of(const Displacements& force, const PerLoad& whole, const Work& work) {
  const PerLoad square = dot(force, force, work);
  double out = 0;
  for (int l = 0; l < 2; ++l)
    if (whole[l] > 0) out = std::max(out, std::sqrt(square[l] / whole[l]));
  return out;
}

// Finds u, and sets `whole`.
Convergence relax(const Elements& elements, const Reference& reference, const Strains& mean, Displacements& u,
                  PerLoad& whole, const Accuracy& accuracy, const Work& work) {
  const std::size_t n = u[0].size();
  Displacements r = zero_displacements(n), p = zero_displacements(n), q = zero_displacements(n), z;
  elements.apply(u, &mean, r, work);
  for (auto& c : r) each(n, work, [&](std::size_t i) { c[i] = -c[i]; });
  whole = dot(r, r, work);
  for (double& w : whole)
    if (w < kRounding * kRounding * 3 * n) w = 0;
  PerLoad before{};
  Convergence out;
  for (;; ++out.iterations) {
    out.residual = residual_of(r, whole, work);
    report(out, accuracy.tolerance, work);
    if (out.residual <= accuracy.tolerance) return out;
    if (out.iterations == accuracy.iterations || !std::isfinite(out.residual))
      throw stalled(out, accuracy.tolerance);
    z = r;
    reference.apply(z, work);
    const PerLoad rz = dot(r, z, work);
    float beta[2], alpha[2];
    for (int l = 0; l < 2; ++l) beta[l] = before[l] > 0 ? rz[l] / before[l] : 0;
    before = rz;
    // Floats with an even index belong to the first load.
    const auto floats = [](auto& field, int c) { return reinterpret_cast<float*>(field[c].data()); };
    for (int c = 0; c < 3; ++c) {
      float *to = floats(p, c), *from = floats(z, c);
      each(2 * n, work, [&](std::size_t i) { to[i] = from[i] + beta[i & 1] * to[i]; });
    }
    elements.apply(p, nullptr, q, work);
    const PerLoad pq = dot(p, q, work);
    for (int l = 0; l < 2; ++l) alpha[l] = pq[l] > 0 ? rz[l] / pq[l] : 0;
    for (int c = 0; c < 3; ++c) {
      float *x = floats(u, c), *res = floats(r, c), *way = floats(p, c), *force = floats(q, c);
      each(2 * n, work, [&](std::size_t i) {
        x[i] += alpha[i & 1] * way[i];
        res[i] -= alpha[i & 1] * force[i];
      });
    }
  }
}

void require_cubes(const VoxelBox& box) {
  if (box.spacing.maxCoeff() <= 1.0001 * box.spacing.minCoeff()) return;
  throw Error("not-cubic",
              fmt::format("voxels of {:.4g} × {:.4g} × {:.4g} mm are not cubes", box.spacing.x(),
                          box.spacing.y(), box.spacing.z()),
              "resample the volume to cubes; stiffness supports nothing else")
      .parameter("property");
}

}  // namespace

double elasticity_bytes(double voxels) { return voxels * (6 * 24 + 4 + 2.0); }

SolvedStiffness stiffness(const PhaseMap& map, const std::vector<Elastic>& values, const Accuracy& accuracy,
                          std::uint64_t memory, const Work& work) {
  require_cubes(map.box);
  const std::size_t n = map.phase.size();
  require_memory(elasticity_bytes(n), memory, "the stiffness of the volume");
  double largest = 0, lambda = 0, mu = 0;
  for (std::size_t i = 0; i < map.count(); ++i)  // of the phases that occur
    if (map.fraction[i] > 0) largest = std::max(largest, values[i].young);
  for (std::size_t i = 0; i < map.count(); ++i) {
    lambda += map.fraction[i] * values[i].lambda();
    mu += map.fraction[i] * values[i].mu();
  }
  SolvedStiffness out;
  out.stress.assign(n, 0);
  if (!(largest > 0)) return out;  // only pores occur
  const Elements elements(map, values, largest);
  const Reference reference(map.box.size, lambda / largest, mu / largest);
  for (int pair = 0; pair < 3; ++pair) {
    Strains mean{};
    for (int l = 0; l < 2; ++l) mean[l][2 * pair + l] = 1;
    PerLoad whole{};
    Displacements u = zero_displacements(n);
    Convergence c =
        relax(elements, reference, mean, u, whole, accuracy, work.part(pair / 3.0, (pair + 1) / 3.0));
    Displacements force = zero_displacements(n);
    const Strains stress = elements.apply(u, &mean, force, work, pair == 0 ? &out.stress : nullptr);
    // The residual of the iteration was updated in single precision, and may differ from that of the forces.
    c.residual = residual_of(force, whole, work);
    if (c.residual > kDrift * accuracy.tolerance) throw stalled(c, accuracy.tolerance);
    out.iterations = std::max(out.iterations, c.iterations);
    out.residual = std::max(out.residual, c.residual);
    for (int l = 0; l < 2; ++l)
      for (int i = 0; i < 6; ++i) out.effective(i, 2 * pair + l) = stress[l][i] * largest;
  }
  for (float& v : out.stress) v *= static_cast<float>(largest);
  return out;
}

}  // namespace terrazzo::homogenize
