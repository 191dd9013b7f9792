#include "nodes/solids/synthesis/exemplar/patch_space.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/exemplar/patch_tree.h"
#include "nodes/solids/synthesis/exemplar/wide.h"

namespace terrazzo::solids {
namespace {

// Reads the patch at a texel, channels interleaved.
void read_patch(const ExemplarLevel& e, std::uint32_t start, float* out) {
  for (int v = 0; v < kPatch; ++v)
    for (int u = 0; u < kPatch; ++u)
      for (int c = 0; c < e.channels; ++c) *out++ = e.texels[4 * (start + pixel_at(u, v, e.width)) + c];
}

struct ProjectArguments {
  const PatchSpace& space;
  const float* picture;
  std::size_t pitch;
  int step, count;
  float* out;
};

// Vectors of 16 dimensions by `Patches` patches stay in registers. Each coordinate is the same sum in the
// same order for every vector width.
template <class Vector, int Patches>
TERRAZZO_INLINE void project_body(const ProjectArguments& a) {
  constexpr int kWidth = sizeof(Vector) / sizeof(float), kVectors = 16 / kWidth;
  const int dims = a.space.dims, row = kPatch * a.space.channels;
  const int stride = a.step * a.space.channels;
  for (int i = 0; i < a.count; i += Patches) {
    const float* patch[Patches];
    for (int p = 0; p < Patches; ++p)
      patch[p] = a.picture + static_cast<std::ptrdiff_t>(std::min(i + p, a.count - 1)) * stride;
    for (int d = 0; d < dims; d += 16) {
      Vector sum[Patches][kVectors];
#pragma GCC unroll 8
      for (int p = 0; p < Patches; ++p)
#pragma GCC unroll 2
        for (int h = 0; h < kVectors; ++h)
          sum[p][h] = -*reinterpret_cast<const Vector*>(&a.space.bias[d + h * kWidth]);
      const float* basis = a.space.basis.data() + d;
      for (int v = 0; v < kPatch; ++v) {
        const std::size_t line = v * a.pitch;
        for (int k = 0; k < row; ++k, basis += dims) {
          Vector x[kVectors];
#pragma GCC unroll 2
          for (int h = 0; h < kVectors; ++h) x[h] = *reinterpret_cast<const Vector*>(basis + h * kWidth);
#pragma GCC unroll 8
          for (int p = 0; p < Patches; ++p) {
            const float value = patch[p][line + k];
#pragma GCC unroll 2
            for (int h = 0; h < kVectors; ++h) sum[p][h] += x[h] * value;
          }
        }
      }
      for (int p = 0; p < Patches && i + p < a.count; ++p)
        for (int h = 0; h < kVectors; ++h)
          *reinterpret_cast<Vector*>(a.out + static_cast<std::ptrdiff_t>(i + p) * dims + d + h * kWidth) =
              sum[p][h];
    }
  }
}
TERRAZZO_AVX512 void project_avx512(const ProjectArguments& a) { project_body<Sixteen, 8>(a); }
TERRAZZO_AVX2 void project_avx2(const ProjectArguments& a) { project_body<Eight, 4>(a); }
void project_plain(const ProjectArguments& a) { project_body<Eight, 4>(a); }

}  // namespace

PatchSpace patch_space(const ExemplarLevel& e, double share, int most) {
  const int n = kPatch * kPatch * e.channels;
  const std::size_t used = std::min<std::size_t>(e.starts.size(), 6000);
  Eigen::MatrixXf patches(n, used);
  for (std::size_t i = 0; i < used; ++i)
    read_patch(e, e.starts[i * e.starts.size() / used], patches.col(i).data());
  const Eigen::VectorXf mean = patches.rowwise().mean();
  patches.colwise() -= mean;
  const Eigen::MatrixXf covariance = patches * patches.transpose() / static_cast<float>(used);
  const auto solver = eigen_axes(covariance);
  const double total = std::max<double>(1e-20, solver.eigenvalues().cwiseMax(0).sum());
  int kept = 0;
  for (double sum = 0; kept < std::min(n, most) && sum < share * total; ++kept)
    sum += std::max(0.0f, solver.eigenvalues()[n - 1 - kept]);
  PatchSpace out;
  out.channels = e.channels;
  out.dims = std::max(16, (kept + 15) / 16 * 16);
  out.basis.assign(static_cast<std::size_t>(n) * out.dims, 0.0f);
  out.bias.assign(out.dims, 0.0f);
  for (int d = 0; d < kept; ++d) {
    const Eigen::VectorXf axis = solver.eigenvectors().col(n - 1 - d);
    for (int k = 0; k < n; ++k) out.basis[k * out.dims + d] = axis[k];
    out.bias[d] = axis.dot(mean);
  }
  return out;
}

void project(const PatchSpace& space, const float* picture, std::size_t pitch, int step, int count,
             float* out) {
  static const auto widest = has_avx512() ? project_avx512 : has_avx2() ? project_avx2 : project_plain;
  widest({space, picture, pitch, step, count, out});
}

void measure_patches(ExemplarLevel& e, const Work& work) {
  const std::size_t dims = e.space.dims, w = e.width;
  e.features.assign(e.height * w * dims, 0.0f);
  std::vector<float> packed(e.height * w * e.channels);
  for (std::size_t i = 0, k = 0; i < w * e.height; ++i)
    for (int c = 0; c < e.channels; ++c) packed[k++] = e.texels[4 * i + c];
  const std::size_t pitch = w * e.channels;
  work.parallel(e.height - kPatch + 1, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      project(e.space, &packed[y * pitch], pitch, 1, e.width - kPatch + 1, &e.features[y * w * dims]);
  });
}

void find_similar(ExemplarLevel& e, const Work& work) {
  constexpr int kK = ExemplarLevel::kSimilar, kApart = 3, kGathered = 16;
  const PatchTree tree(e.features.data(), e.space.dims, e.starts);
  e.similar.assign(pixels_in(e.width, e.height) * kK, 0);
  const auto near = [&](std::uint32_t a, std::uint32_t b) {
    const int w = e.width, ax = static_cast<int>(a) % w, ay = static_cast<int>(a) / w;
    return std::abs(ax - static_cast<int>(b) % w) < kApart && std::abs(ay - static_cast<int>(b) / w) < kApart;
  };
  work.parallel(e.starts.size(), 256, [&](std::size_t begin, std::size_t end) {
    std::vector<PatchTree::Hit> hits;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t self = e.starts[i];
      // Approximate neighbors suffice: the search ends after 24 leaves.
      tree.nearest(
          e.feature(self), kGathered, 0, 24, [&](std::uint32_t other) { return !near(self, other); }, hits);
      std::uint32_t* out = &e.similar[static_cast<std::size_t>(self) * kK];
      int found = 0;
      for (const auto& h : hits) {
        bool fresh = found < kK;
        for (int j = 0; j < found; ++j) fresh &= !near(out[j], h.item);
        if (fresh) out[found++] = h.item;
      }
      for (; found < kK; ++found) out[found] = self;
    }
  });
}

}  // namespace terrazzo::solids
