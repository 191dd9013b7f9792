#include "nodes/properties/homogenize/elements.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/properties/homogenize/vectors.h"

namespace terrazzo::homogenize {
namespace {

constexpr int kLayers = 4;  // of elements that one thread adds up

// The displacements in a voxel, with coordinates ξ, η, ζ from −½ to ½ along x, y, z, are the sum of eight
// modes, products of 1 and ξ, 1 and η, 1 and ζ. They are orthogonal, so that the exact integral of the energy
// is a sum over modes. A mode is named by what it is along y and z: a mean or a difference of the nodes'
// values.
enum Across { MeanMean, DifferenceMean, MeanDifference, DifferenceDifference };  // along y, along z

// ∫ ξ² = 1/12
constexpr float kSecond = 1 / 12.0F, kFourth = 1 / 144.0F;

}  // namespace

Displacements zero_displacements(std::size_t count) {
  Displacements out;
  for (auto& c : out) c.assign(count, {});
  return out;
}

// The floats of a row of elements, two for each: one for each load.
struct Elements::Rows {
  explicit Rows(int n) : floats(2 * n) {
    for (auto& component : across)
      for (auto& row : component) row.resize(floats + 2);  // ends with the first node again
    for (auto& component : mean)
      for (auto& row : component) row.resize(floats + 2);  // begin with the last element
    for (auto& component : difference)
      for (auto& row : component) row.resize(floats + 2);
    for (auto& row : strain) row.assign(floats, 0);
    lambda.resize(floats);
    mu.resize(floats);
  }
  int floats;
  std::vector<float> across[3][4];      // the nodes' values, by component and Across
  std::vector<float> mean[3][4];        // forces on the modes that are constant along x
  std::vector<float> difference[3][4];  // and on those that are linear
  std::vector<float> strain[6];         // mean strains
  std::vector<float> lambda, mu;
};

Elements::Elements(const PhaseMap& map, const std::vector<Elastic>& values, double unit)
    : size_(map.box.size), phase_(map.phase) {
  for (const Elastic& v : values) {
    lambda_.push_back(v.lambda() / unit);
    mu_.push_back(v.mu() / unit);
  }
}

void Elements::gather(const Displacements& u, int y, int z, Rows& rows) const {
  const int north = y + 1 == size_.y() ? 0 : y + 1, above = z + 1 == size_.z() ? 0 : z + 1;
  for (int c = 0; c < 3; ++c) {
    const auto row = [&](int j, int k) {
      return reinterpret_cast<const float*>(u[c].data() + voxel_at(0, j, k, size_));
    };
    const float *a = row(y, z), *b = row(north, z), *d = row(y, above), *e = row(north, above);
    float *mm = rows.across[c][MeanMean].data(), *dm = rows.across[c][DifferenceMean].data(),
          *md = rows.across[c][MeanDifference].data(), *dd = rows.across[c][DifferenceDifference].data();
    for (int i = 0; i < rows.floats; ++i) {
      mm[i] = 0.25F * (a[i] + b[i] + d[i] + e[i]);
      dm[i] = 0.5F * (b[i] - a[i] + e[i] - d[i]);
      md[i] = 0.5F * (d[i] - a[i] + e[i] - b[i]);
      dd[i] = e[i] - d[i] - b[i] + a[i];
    }
    for (auto& r : rows.across[c]) std::copy_n(r.begin(), 2, r.end() - 2);
  }
}

void Elements::load_moduli(int y, int z, Rows& rows) const {
  const std::uint8_t* phase = phase_.data() + voxel_at(0, y, z, size_);
  for (int x = 0; x < size_.x(); ++x)
    for (int l = 0; l < 2; ++l) {
      rows.lambda[2 * x + l] = lambda_[phase[x]];
      rows.mu[2 * x + l] = mu_[phase[x]];
    }
}

// Stress modes from strain modes by Hooke's law, mode by mode.
void Elements::find_forces(Rows& rows) {
  const auto& s = rows.across;
  const int n = rows.floats;
  const float *lambda = rows.lambda.data(), *mu = rows.mu.data();
  const float *u0 = s[0][0].data(), *u1 = s[0][1].data(), *u2 = s[0][2].data(), *u3 = s[0][3].data();
  const float *v0 = s[1][0].data(), *v1 = s[1][1].data(), *v2 = s[1][2].data(), *v3 = s[1][3].data();
  const float *w0 = s[2][0].data(), *w1 = s[2][1].data(), *w2 = s[2][2].data(), *w3 = s[2][3].data();
  const auto out = [&](std::vector<float>(&f)[3][4], int c, int k) { return f[c][k].data() + 2; };
  float *uD0 = out(rows.difference, 0, 0), *uD1 = out(rows.difference, 0, 1),
        *uD2 = out(rows.difference, 0, 2), *uD3 = out(rows.difference, 0, 3), *uM1 = out(rows.mean, 0, 1),
        *uM2 = out(rows.mean, 0, 2), *uM3 = out(rows.mean, 0, 3);
  float *vD0 = out(rows.difference, 1, 0), *vD1 = out(rows.difference, 1, 1),
        *vD2 = out(rows.difference, 1, 2), *vD3 = out(rows.difference, 1, 3), *vM1 = out(rows.mean, 1, 1),
        *vM2 = out(rows.mean, 1, 2), *vM3 = out(rows.mean, 1, 3);
  float *wD0 = out(rows.difference, 2, 0), *wD1 = out(rows.difference, 2, 1),
        *wD2 = out(rows.difference, 2, 2), *wD3 = out(rows.difference, 2, 3), *wM1 = out(rows.mean, 2, 1),
        *wM2 = out(rows.mean, 2, 2), *wM3 = out(rows.mean, 2, 3);
  const float *exx = rows.strain[0].data(), *eyy = rows.strain[1].data(), *ezz = rows.strain[2].data(),
              *gyz = rows.strain[3].data(), *gxz = rows.strain[4].data(), *gxy = rows.strain[5].data();
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float l = lambda[i], m = mu[i];
    const int j = i + 2;  // the next node
    // Constant strains.
    const float xx = u0[j] - u0[i] + exx[i], yy = 0.5F * (v1[i] + v1[j]) + eyy[i],
                zz = 0.5F * (w2[i] + w2[j]) + ezz[i], trace = l * (xx + yy + zz);
    uD0[i] = trace + 2 * m * xx;
    vM1[i] = trace + 2 * m * yy;
    wM2[i] = trace + 2 * m * zz;
    uM1[i] = vD0[i] = m * (0.5F * (u1[i] + u1[j]) + v0[j] - v0[i] + gxy[i]);
    uM2[i] = wD0[i] = m * (0.5F * (u2[i] + u2[j]) + w0[j] - w0[i] + gxz[i]);
    vM2[i] = wM1[i] = m * (0.5F * (v2[i] + v2[j]) + 0.5F * (w1[i] + w1[j]) + gyz[i]);
    // Strains that are linear along one axis.
    const float uxy = u1[j] - u1[i], uxz = u2[j] - u2[i], uyz = 0.5F * (u3[i] + u3[j]);
    const float vxy = v1[j] - v1[i], vxz = v2[j] - v2[i], vyz = 0.5F * (v3[i] + v3[j]);
    const float wxy = w1[j] - w1[i], wxz = w2[j] - w2[i], wyz = 0.5F * (w3[i] + w3[j]);
    const float along_x = l * (vxy + wxz), along_y = l * (uxy + wyz), along_z = l * (uxz + vyz);
    uD1[i] = kSecond * (along_y + 3 * m * uxy);
    uD2[i] = kSecond * (along_z + 3 * m * uxz);
    vD1[i] = kSecond * (along_x + 3 * m * vxy);
    vM3[i] = kSecond * (along_z + 3 * m * vyz);
    wD2[i] = kSecond * (along_x + 3 * m * wxz);
    wM3[i] = kSecond * (along_y + 3 * m * wyz);
    uM3[i] = kSecond * m * (2 * uyz + vxz + wxy);
    vD2[i] = kSecond * m * (2 * vxz + uyz + wxy);
    wD1[i] = kSecond * m * (2 * wxy + uyz + vxz);
    // Those that are linear along two axes.
    const float both = kFourth * (l + 4 * m);
    uD3[i] = both * (u3[j] - u3[i]);
    vD3[i] = both * (v3[j] - v3[i]);
    wD3[i] = both * (w3[j] - w3[i]);
  }
}

void Elements::scatter(Rows& rows, int y, int z, Displacements& force) const {
  const int north = y + 1 == size_.y() ? 0 : y + 1, above = z + 1 == size_.z() ? 0 : z + 1;
  const int n = rows.floats;
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 4; ++k) {
      for (auto* modes : {&rows.mean[c][k], &rows.difference[c][k]})
        std::copy_n(modes->end() - 2, 2, modes->begin());
      // From modes of elements to nodes: f[i] is of the element behind node i, f[i + 2] of that ahead.
      const float *mean = rows.mean[c][k].data(), *difference = rows.difference[c][k].data();
      float* to = rows.across[c][k].data();
      for (int i = 0; i < n; ++i)
        to[i] = (k == MeanMean ? 0 : 0.5F * (mean[i] + mean[i + 2])) + difference[i] - difference[i + 2];
    }
    const auto row = [&](int j, int k) {
      return reinterpret_cast<float*>(force[c].data() + voxel_at(0, j, k, size_));
    };
    const float *mm = rows.across[c][MeanMean].data(), *dm = rows.across[c][DifferenceMean].data(),
                *md = rows.across[c][MeanDifference].data(),
                *dd = rows.across[c][DifferenceDifference].data();
    const auto add = [&](float* to, float along_y, float along_z) {
      for (int i = 0; i < n; ++i)
        to[i] += 0.25F * mm[i] + 0.5F * (along_y * dm[i] + along_z * md[i]) + along_y * along_z * dd[i];
    };
    add(row(y, z), -1, -1);
    add(row(north, z), 1, -1);
    add(row(y, above), -1, 1);
    add(row(north, above), 1, 1);
  }
}

void Elements::add_stresses(const Rows& rows, Strains& sums, float* mises) const {
  const float* of[6] = {rows.difference[0][0].data() + 2, rows.mean[1][1].data() + 2,
                        rows.mean[2][2].data() + 2,       rows.mean[1][2].data() + 2,
                        rows.mean[0][2].data() + 2,       rows.mean[0][1].data() + 2};
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < rows.floats; ++i) sums[i & 1][k] += of[k][i];
  if (!mises) return;
  for (int x = 0; x < size_.x(); ++x) {
    double s[6];
    for (int k = 0; k < 6; ++k) s[k] = of[k][2 * x];
    const double differences = std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2);
    mises[x] =
        static_cast<float>(std::sqrt(0.5 * differences + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])));
  }
}

Strains Elements::apply(const Displacements& u, const Strains* mean, Displacements& force, const Work& work,
                        std::vector<float>* mises) const {
  for (auto& c : force) each(c.size(), work, [&](std::size_t i) { c[i] = 0; });
  if (mises) mises->assign(phase_.size(), 0);
  const std::size_t slabs = (size_.z() + kLayers - 1) / kLayers;
  std::vector<Strains> sums(slabs);
  const auto add_slab = [&](std::size_t slab) {
    Rows rows(size_.x());
    if (mean)
      for (int k = 0; k < 6; ++k)
        for (int i = 0; i < rows.floats; ++i) rows.strain[k][i] = (*mean)[i & 1][k];
    for (int z = slab * kLayers; z < std::min<int>(size_.z(), (slab + 1) * kLayers); ++z) {
      work.check();
      for (int y = 0; y < size_.y(); ++y) {
        gather(u, y, z, rows);
        load_moduli(y, z, rows);
        find_forces(rows);
        if (mean) add_stresses(rows, sums[slab], mises ? mises->data() + voxel_at(0, y, z, size_) : nullptr);
        scatter(rows, y, z, force);
      }
    }
  };
  // Neighboring slabs add to the layer of nodes between them, so they take turns: even ones, odd ones, and
  // the last of an odd number, whose next one is the first.
  const std::size_t pairs = slabs / 2;
  for (std::size_t turn = 0; turn < 2; ++turn)
    work.quiet().parallel(pairs, 1, [&](std::size_t begin, std::size_t) { add_slab(2 * begin + turn); });
  if (slabs % 2 == 1) add_slab(slabs - 1);
  Strains out{};
  for (const Strains& s : sums)
    for (int l = 0; l < 2; ++l)
      for (int k = 0; k < 6; ++k) out[l][k] += s[l][k] / phase_.size();
  return out;
}

}  // namespace terrazzo::homogenize
