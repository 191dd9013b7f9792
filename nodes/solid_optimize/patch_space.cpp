#include "nodes/solid_optimize/patch_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "nodes/solid_optimize/patch_tree.h"
#include "nodes/solid_optimize/wide.h"

namespace terrazzo::solid_optimize {
namespace {

// The patch at a texel, channels interleaved.
void read_patch(const ExemplarLevel& e, std::uint32_t start, float* out) {
  for (int v = 0; v < kPatch; ++v)
    for (int u = 0; u < kPatch; ++u)
      for (int c = 0; c < e.channels; ++c)
        *out++ = e.texels[4 * (start + static_cast<std::size_t>(v) * static_cast<std::size_t>(e.width) +
                               static_cast<std::size_t>(u)) +
                          static_cast<std::size_t>(c)];
}

struct ProjectArguments {
  const PatchSpace& space;
  const float* picture;
  std::size_t pitch;
  int step, count;
  float* out;
};

// Four patches by sixteen dimensions stay in registers.
TERRAZZO_INLINE void project_body(const ProjectArguments& a) {
  const int dims = a.space.dims, row = kPatch * a.space.channels;
  const int stride = a.step * a.space.channels;
  for (int i = 0; i < a.count; i += 4) {
    const float* patch[4];
    for (int p = 0; p < 4; ++p)
      patch[p] = a.picture + static_cast<std::ptrdiff_t>(std::min(i + p, a.count - 1)) * stride;
    for (int d = 0; d < dims; d += 16) {
      const Eight b0 = -*reinterpret_cast<const Eight*>(&a.space.bias[static_cast<std::size_t>(d)]);
      const Eight b1 = -*reinterpret_cast<const Eight*>(&a.space.bias[static_cast<std::size_t>(d) + 8]);
      Eight s00 = b0, s01 = b1, s10 = b0, s11 = b1, s20 = b0, s21 = b1, s30 = b0, s31 = b1;
      const float* basis = a.space.basis.data() + d;
      for (int v = 0; v < kPatch; ++v) {
        const std::size_t line = static_cast<std::size_t>(v) * a.pitch;
        const float *p0 = patch[0] + line, *p1 = patch[1] + line, *p2 = patch[2] + line,
                    *p3 = patch[3] + line;
        for (int k = 0; k < row; ++k, basis += dims) {
          const Eight x0 = *reinterpret_cast<const Eight*>(basis),
                      x1 = *reinterpret_cast<const Eight*>(basis + 8);
          s00 += x0 * p0[k], s01 += x1 * p0[k], s10 += x0 * p1[k], s11 += x1 * p1[k];
          s20 += x0 * p2[k], s21 += x1 * p2[k], s30 += x0 * p3[k], s31 += x1 * p3[k];
        }
      }
      const Eight* sums[4][2] = {{&s00, &s01}, {&s10, &s11}, {&s20, &s21}, {&s30, &s31}};
      for (int p = 0; p < 4 && i + p < a.count; ++p)
        for (int h = 0; h < 2; ++h)
          *reinterpret_cast<Eight*>(a.out + static_cast<std::ptrdiff_t>(i + p) * dims + d + 8 * h) =
              *sums[p][h];
    }
  }
}
TERRAZZO_AVX2 void project_avx2(const ProjectArguments& a) { project_body(a); }
void project_plain(const ProjectArguments& a) { project_body(a); }

}  // namespace

PatchSpace principal_axes(const ExemplarLevel& e, double share, int most) {
  const int n = kPatch * kPatch * e.channels;
  const std::size_t used = std::min<std::size_t>(e.starts.size(), 6000);
  Eigen::MatrixXf patches(n, static_cast<Eigen::Index>(used));
  for (std::size_t i = 0; i < used; ++i)
    read_patch(e, e.starts[i * e.starts.size() / used], patches.col(static_cast<Eigen::Index>(i)).data());
  const Eigen::VectorXf mean = patches.rowwise().mean();
  patches.colwise() -= mean;
  const Eigen::MatrixXf covariance = patches * patches.transpose() / static_cast<float>(used);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(covariance);
  const double total = std::max(1e-20, static_cast<double>(solver.eigenvalues().cwiseMax(0).sum()));
  int kept = 0;
  for (double sum = 0; kept < std::min(n, most) && sum < share * total; ++kept)
    sum += std::max(0.0f, solver.eigenvalues()[n - 1 - kept]);
  PatchSpace out;
  out.channels = e.channels;
  out.dims = std::max(16, (kept + 15) / 16 * 16);
  out.basis.assign(static_cast<std::size_t>(n) * static_cast<std::size_t>(out.dims), 0.0f);
  out.bias.assign(static_cast<std::size_t>(out.dims), 0.0f);
  for (int d = 0; d < kept; ++d) {
    const Eigen::VectorXf axis = solver.eigenvectors().col(n - 1 - d);
    for (int k = 0; k < n; ++k) out.basis[static_cast<std::size_t>(k * out.dims + d)] = axis[k];
    out.bias[static_cast<std::size_t>(d)] = axis.dot(mean);
  }
  return out;
}

void project(const PatchSpace& space, const float* picture, std::size_t pitch, int step, int count,
             float* out) {
  static const bool avx2 = has_avx2();
  const ProjectArguments a{space, picture, pitch, step, count, out};
  avx2 ? project_avx2(a) : project_plain(a);
}

void measure_patches(ExemplarLevel& e, const Work& work) {
  const std::size_t dims = static_cast<std::size_t>(e.space.dims), w = static_cast<std::size_t>(e.width);
  e.features.assign(static_cast<std::size_t>(e.height) * w * dims, 0.0f);
  std::vector<float> packed(static_cast<std::size_t>(e.height) * w * static_cast<std::size_t>(e.channels));
  for (std::size_t i = 0, k = 0; i < w * static_cast<std::size_t>(e.height); ++i)
    for (int c = 0; c < e.channels; ++c) packed[k++] = e.texels[4 * i + static_cast<std::size_t>(c)];
  const std::size_t pitch = w * static_cast<std::size_t>(e.channels);
  work.parallel(static_cast<std::size_t>(e.height - kPatch + 1), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      project(e.space, &packed[y * pitch], pitch, 1, e.width - kPatch + 1, &e.features[y * w * dims]);
  });
}

void find_similar(ExemplarLevel& e, const Work& work) {
  constexpr int k = ExemplarLevel::kSimilar, apart = 3, gathered = 16;
  const PatchTree tree(e.features.data(), e.space.dims, e.starts);
  e.similar.assign(static_cast<std::size_t>(e.width) * static_cast<std::size_t>(e.height) * k, 0);
  const auto near = [&](std::uint32_t a, std::uint32_t b) {
    const int w = e.width, ax = static_cast<int>(a) % w, ay = static_cast<int>(a) / w;
    return std::abs(ax - static_cast<int>(b) % w) < apart && std::abs(ay - static_cast<int>(b) / w) < apart;
  };
  work.parallel(e.starts.size(), 256, [&](std::size_t begin, std::size_t end) {
    std::vector<PatchTree::Hit> hits;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t self = e.starts[i];
      // Near enough is good enough: a dozen leaves.
      tree.nearest(
          e.feature(self), gathered, 0, 24, [&](std::uint32_t other) { return !near(self, other); }, hits);
      std::uint32_t* out = &e.similar[static_cast<std::size_t>(self) * k];
      int found = 0;
      for (const auto& h : hits) {
        bool fresh = found < k;
        for (int j = 0; j < found; ++j) fresh &= !near(out[j], h.item);
        if (fresh) out[found++] = h.item;
      }
      for (; found < k; ++found) out[found] = self;
    }
  });
}

}  // namespace terrazzo::solid_optimize
