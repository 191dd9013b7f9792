#include "nodes/solids/patch_fill/finish.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace terrazzo::patch_fill {
namespace {

constexpr int kScales = 2;
constexpr double kMostGain = 2;

// A mean with weights 1, 2, 1 of voxels `apart` from each other, along each axis.
Torus<Vec3f> smooth(Torus<Vec3f> t, int apart, const Work& work) {
  Torus<Vec3f> out = t;
  for (int axis = 0; axis < 3; ++axis) {
    work.parallel(t.at.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Vec3i before = t.place(i), after = before;
        before[axis] = wrapped(before[axis] - apart, t.size[axis]);
        after[axis] = wrapped(after[axis] + apart, t.size[axis]);
        out.at[i] = 0.25f * (t.at[t.index(before.x(), before.y(), before.z())] +
                             t.at[t.index(after.x(), after.y(), after.z())]) +
                    0.5f * t.at[i];
      }
    });
    std::swap(t, out);
  }
  return t;
}

// The field's scales from fine to coarse, and what is left.
std::vector<Torus<Vec3f>> scales_of(const Torus<Vec3f>& field, const Work& work) {
  std::vector<Torus<Vec3f>> out = {field};
  for (int k = 0; k < kScales; ++k) {
    Torus<Vec3f> rest = smooth(out.back(), 1 << k, work);
    for (std::size_t i = 0; i < rest.at.size(); ++i) out.back().at[i] -= rest.at[i];
    out.push_back(std::move(rest));
  }
  return out;
}

}  // namespace

void restore_detail(const std::array<Torus<Vec3f>, 2>& textures, const Torus<float>& weight,
                    const Torus<float>& free, Torus<Vec3f>& field, const Work& work) {
  std::array<std::array<Vec3, kScales>, 2> wanted;  // mean squares
  for (std::size_t s = 0; s < 2; ++s) {
    const auto scales = scales_of(textures[s], work);
    for (std::size_t k = 0; k < kScales; ++k) {
      wanted[s][k] = Vec3::Zero();
      for (const Vec3f& v : scales[k].at) wanted[s][k] += v.cast<double>().cwiseAbs2();
      wanted[s][k] /= static_cast<double>(weight.at.size());
    }
  }
  const auto scales = scales_of(field, work);
  for (std::size_t k = 0; k < kScales; ++k) {
    Vec3 have = Vec3::Zero(), want = Vec3::Zero();
    for (std::size_t i = 0; i < weight.at.size(); ++i) {
      const double w = weight.at[i];
      if (free.at[i] <= 0) continue;
      have += scales[k].at[i].cast<double>().cwiseAbs2();
      const Vec3 deviation = (1 - w) * wanted[0][k].cwiseSqrt() + w * wanted[1][k].cwiseSqrt();
      want += deviation.cwiseAbs2();
    }
    Vec3f gain;
    for (int c = 0; c < 3; ++c)
      gain[c] = have[c] > 0 ? std::clamp(std::sqrt(want[c] / have[c]), 1.0, kMostGain) : 1;
    for (std::size_t i = 0; i < weight.at.size(); ++i)
      if (free.at[i] > 0) field.at[i] += (gain.array() - 1).matrix().cwiseProduct(scales[k].at[i]);
  }
}

}  // namespace terrazzo::patch_fill
