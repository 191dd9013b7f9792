#include "nodes/common/texture/texture_measures.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/quantiles.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

constexpr int kSide = 7, kScales = 3, kDirections = 48;
constexpr std::size_t kPatches = 2048;  // per scale

PatchPicture picture_of(const TexturePart& part) {
  PatchPicture p;
  p.width = part.image->width;
  p.height = part.image->height;
  const auto n = pixels_in(p.width, p.height);
  for (std::size_t i = 0; i < n; ++i) p.pixels.push_back(linear_to_oklab(part.image->pixels[i]));
  p.inside = part.mask;
  return p;
}

PatchPicture halved(const PatchPicture& in) {
  PatchPicture out;
  out.width = in.width / 2;
  out.height = in.height / 2;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(2 * y) * in.width + 2 * x, below = i + in.width;
      out.pixels.push_back((in.pixels[i] + in.pixels[i + 1] + in.pixels[below] + in.pixels[below + 1]) / 4);
      if (!in.inside.empty())
        out.inside.push_back(in.inside[i] && in.inside[i + 1] && in.inside[below] && in.inside[below + 1]);
    }
  return out;
}

// Top left corners of the patches that are completely inside.
std::vector<std::size_t> corners_of(const PatchPicture& p) {
  const int w = p.width + 1;
  std::vector<std::int32_t> sum(static_cast<std::size_t>(w) * (p.height + 1), 0);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      sum[pixel_at(x, y + 1, w) + 1] = (p.inside.empty() || p.inside[pixel_at(x, y, p.width)]) +
                                       sum[pixel_at(x, y, w) + 1] + sum[pixel_at(x, y + 1, w)] -
                                       sum[pixel_at(x, y, w)];
  std::vector<std::size_t> out;
  for (int y = 0; y + kSide <= p.height; ++y)
    for (int x = 0; x + kSide <= p.width; ++x)
      if (sum[pixel_at(x, y + kSide, w) + kSide] - sum[pixel_at(x, y, w) + kSide] -
              sum[pixel_at(x, y + kSide, w)] + sum[pixel_at(x, y, w)] ==
          kSide * kSide)
        out.push_back(pixel_at(x, y, p.width));
  return out;
}

// Sorted projections of patches onto random directions, per direction. Empty if no patch fits.
std::vector<std::vector<float>> project(const std::vector<PatchPicture>& pictures, std::uint64_t draw,
                                        const Work& work) {
  struct Corner {
    const PatchPicture* picture;
    std::size_t at;
  };
  std::vector<Corner> corners;
  for (const PatchPicture& p : pictures)
    for (const std::size_t at : corners_of(p)) corners.push_back({&p, at});
  if (corners.empty()) return {};
  constexpr int kN = kSide * kSide;
  std::vector<std::vector<float>> out(kDirections);
  work.parallel(kDirections, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t d = begin; d < end; ++d) {
      Random random(7, 1, d);
      Vec3f direction[kN];
      double square = 0;
      for (auto& v : direction) {
        const double x = random.normal(), y = random.normal(), z = random.normal();
        v = Vec3(x, y, z).cast<float>();
        square += x * x + y * y + z * z;
      }
      const float unit = 1 / std::sqrt(square);
      for (std::size_t i = 0; i < kPatches; ++i) {
        // Stratified, so that patches are spread evenly even if there are few.
        const std::size_t lo = i * corners.size() / kPatches, hi = (i + 1) * corners.size() / kPatches;
        const Corner& corner = corners[hi > lo ? lo + Random(7, 2 + draw, i).below(hi - lo) : lo];
        const PatchPicture& p = *corner.picture;
        float sum = 0;
        for (int v = 0; v < kSide; ++v)
          for (int u = 0; u < kSide; ++u)
            sum += p.pixels[corner.at + pixel_at(u, v, p.width)].dot(direction[v * kSide + u]);
        out[d].push_back(sum * unit);
      }
      std::sort(out[d].begin(), out[d].end());
    }
  });
  return out;
}

}  // namespace

double histogram_distance(const TexturePart& a, const TexturePart& b) {
  const PatchPicture pa = picture_of(a), pb = picture_of(b);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const auto values = [&](const PatchPicture& p) {
      std::vector<float> v;
      for (std::size_t i = 0; i < p.pixels.size(); ++i)
        if (p.inside.empty() || p.inside[i]) v.push_back(p.pixels[i][k]);
      return v;
    };
    const auto va = values(pa), vb = values(pb);
    if (va.empty() || vb.empty()) return -1;
    const Quantiles qa = quantiles_of(va), qb = quantiles_of(vb);
    constexpr int kSteps = 512;
    for (int i = 0; i < kSteps; ++i)
      sum += std::abs(qa.of((i + 0.5) / kSteps) - qb.of((i + 0.5) / kSteps)) / kSteps / 3;
  }
  return sum;
}

double patch_distance(std::vector<PatchPicture> a, std::vector<PatchPicture> b, std::uint64_t draw,
                      const Work& work) {
  double sum = 0;
  int scales = 0;
  for (int s = 0; s < kScales; ++s) {
    const auto qa = project(a, 2 * draw, work.quiet()), qb = project(b, 2 * draw + 1, work.quiet());
    if (qa.empty() || qb.empty()) break;
    double square = 0;
    for (int d = 0; d < kDirections; ++d)
      for (std::size_t i = 0; i < kPatches; ++i) {
        const double e = qa[d][i] - qb[d][i];
        square += e * e;
      }
    sum += square / (kDirections * static_cast<double>(kPatches));
    ++scales;
    for (auto& p : a) p = halved(p);
    for (auto& p : b) p = halved(p);
  }
  return scales > 0 ? std::sqrt(sum / scales) : -1;
}

double patch_distance(const TexturePart& a, const TexturePart& b, std::uint64_t draw, const Work& work) {
  return patch_distance({picture_of(a)}, {picture_of(b)}, draw, work);
}

double nearest_patch(const std::vector<PatchPicture>& a, const std::vector<PatchPicture>& b, double share,
                     const Work& work) {
  // One patch per column, and half of its squared norm.
  static constexpr int kValues = 3 * kSide * kSide;
  struct Columns {
    Eigen::MatrixXf patch;
    Eigen::VectorXf half;
  };
  const auto columns = [](const std::vector<PatchPicture>& pictures, std::size_t most, std::uint64_t stream) {
    std::vector<std::pair<const PatchPicture*, std::size_t>> corners;
    for (const PatchPicture& p : pictures)
      for (const std::size_t at : corners_of(p)) corners.emplace_back(&p, at);
    const std::size_t count = std::min(most, corners.size());
    Columns c{Eigen::MatrixXf(kValues, count), {}};
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t lo = i * corners.size() / count, hi = (i + 1) * corners.size() / count;
      const auto& [p, at] = corners[lo + Random(11, stream, i).below(hi - lo)];
      for (int v = 0, row = 0; v < kSide; ++v)
        for (int u = 0; u < kSide; ++u)
          for (int k = 0; k < 3; ++k, ++row)
            c.patch(row, i) = p->pixels[at + static_cast<std::size_t>(v) * p->width + u][k];
    }
    c.half = 0.5f * c.patch.colwise().squaredNorm();
    return c;
  };
  const Columns from = columns(a, kPatches / 2, 0), to = columns(b, kPatches, 1);
  const std::size_t count = from.patch.cols();
  if (count == 0 || to.patch.cols() == 0) return -1;
  std::vector<float> nearest(count);
  work.parallel(count, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Index column = i;
      const float least =
          (to.half - to.patch.transpose() * from.patch.col(column)).minCoeff() + from.half[column];
      nearest[i] = std::sqrt(std::max(0.0f, 2 * least) / kValues);
    }
  });
  std::sort(nearest.begin(), nearest.end());
  return nearest[std::min<std::size_t>(count - 1, share * count)];
}

double patch_distance_floor(const Image& image, const Work& work) {
  const auto part = [&](auto&& keep) {
    TexturePart p{&image, {}};
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) p.mask.push_back(keep(x, y));
    return p;
  };
  return std::max(patch_distance(part([&](int x, int) { return 2 * x < image.width; }),
                                 part([&](int x, int) { return 2 * x >= image.width; }), 0, work),
                  patch_distance(part([&](int, int y) { return 2 * y < image.height; }),
                                 part([&](int, int y) { return 2 * y >= image.height; }), 0, work));
}

}  // namespace terrazzo
