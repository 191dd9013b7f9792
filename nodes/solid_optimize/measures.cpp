#include "nodes/solid_optimize/measures.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/band_statistics.h"
#include "nodes/common/slice_family.h"
#include "nodes/common/steerable_pyramid.h"
#include "runtime/random.h"

namespace terrazzo::solid_optimize {
namespace {

constexpr int kSide = 7, kScales = 3, kDirections = 48;
constexpr std::size_t kPatches = 2048;  // of each scale

struct Picture {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;
};

Picture slice_picture(const SolidField& field, int axis, int slice) {
  Picture p;
  const int u = kSliceColumns[axis], v = kSliceRows[axis];
  p.width = field.size[u], p.height = field.size[v];
  int at[3];
  at[axis] = slice;
  for (at[v] = 0; at[v] < p.height; ++at[v])
    for (at[u] = 0; at[u] < p.width; ++at[u]) {
      const std::size_t i =
          (static_cast<std::size_t>(at[2]) * field.size.y() + at[1]) * field.size.x() + at[0];
      Vec3f c = Vec3f::Zero();
      for (std::size_t k = 0; k < field.channel.size(); ++k)
        c[static_cast<Eigen::Index>(k)] = field.channel[k][i];
      p.pixels.push_back(c);
    }
  return p;
}

Picture halved(const Picture& in) {
  Picture out;
  out.width = in.width / 2, out.height = in.height / 2;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Vec3f* p = &in.pixels[static_cast<std::size_t>(2 * y) * in.width + 2 * x];
      out.pixels.push_back((p[0] + p[1] + p[in.width] + p[in.width + 1]) / 4);
    }
  return out;
}

// Sorted projections of patches drawn from the pictures, per direction. Empty where no patch fits.
using Projections = std::vector<std::vector<float>>;
Projections project_patches(const std::vector<Picture>& pictures, std::uint64_t stream) {
  Projections out(kDirections);
  if (pictures[0].width < kSide || pictures[0].height < kSide) return out;
  constexpr int n = kSide * kSide;
  std::vector<Vec3f> directions(static_cast<std::size_t>(kDirections) * n);
  for (int d = 0; d < kDirections; ++d) {
    Random random(7, 1, static_cast<std::uint64_t>(d));
    double square = 0;
    for (int k = 0; k < n; ++k) {
      const Vec3 v(random.normal(), random.normal(), random.normal());
      directions[static_cast<std::size_t>(d) * n + k] = v.cast<float>(), square += v.squaredNorm();
    }
    for (int k = 0; k < n; ++k)
      directions[static_cast<std::size_t>(d) * n + k] /= static_cast<float>(std::sqrt(square / n));
  }
  for (std::size_t i = 0; i < kPatches; ++i) {
    Random random(7, stream, i);
    const Picture& p = pictures[i % pictures.size()];
    const int x = static_cast<int>(random.below(static_cast<std::uint64_t>(p.width - kSide + 1))),
              y = static_cast<int>(random.below(static_cast<std::uint64_t>(p.height - kSide + 1)));
    Vec3f patch[n];
    for (int v = 0; v < kSide; ++v)
      for (int u = 0; u < kSide; ++u)
        patch[v * kSide + u] = p.pixels[static_cast<std::size_t>(y + v) * p.width + x + u];
    for (int d = 0; d < kDirections; ++d) {
      float sum = 0;
      for (int k = 0; k < n; ++k) sum += patch[k].dot(directions[static_cast<std::size_t>(d) * n + k]);
      out[static_cast<std::size_t>(d)].push_back(sum / kSide);
    }
  }
  for (auto& d : out) std::sort(d.begin(), d.end());
  return out;
}

// Mean square over directions and quantiles of the difference; negative where there are none.
double distance2(const Projections& a, const Projections& b) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t d = 0; d < a.size(); ++d)
    for (std::size_t i = 0; i < std::min(a[d].size(), b[d].size()); ++i, ++n)
      sum += (a[d][i] - b[d][i]) * (a[d][i] - b[d][i]);
  return n > 0 ? sum / static_cast<double>(n) : -1;
}

double patch_distance(std::vector<Picture> a, std::vector<Picture> b) {
  double sum = 0;
  int scales = 0;
  for (int s = 0; s < kScales; ++s) {
    const double d = distance2(project_patches(a, 2), project_patches(b, 3));
    if (d < 0) break;
    sum += d, ++scales;
    for (auto& p : a) p = halved(p);
    for (auto& p : b) p = halved(p);
  }
  return scales > 0 ? std::sqrt(sum / scales) : 0;
}

Picture part_of(const SolidExemplar& e, int x0, int y0, int x1, int y1) {
  Picture p;
  p.width = x1 - x0, p.height = y1 - y0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) p.pixels.push_back(e.pixels[static_cast<std::size_t>(y) * e.width + x]);
  return p;
}

// Squared gradients along columns and rows, and their product.
Eigen::Array3d gradients(const Picture& p) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (int y = 0; y + 1 < p.height; ++y)
    for (int x = 0; x + 1 < p.width; ++x) {
      const Vec3f* c = &p.pixels[static_cast<std::size_t>(y) * p.width + x];
      const Vec3f du = ((c[1] - c[0]) + (c[p.width + 1] - c[p.width])) / 2,
                  dv = ((c[p.width] - c[0]) + (c[p.width + 1] - c[1])) / 2;
      sum += Eigen::Array3d(du.squaredNorm(), dv.squaredNorm(), du.dot(dv));
    }
  return sum;
}

// Mean |difference| between slice s and the next.
double step_across(const SolidField& field, int axis, int slice) {
  const Picture a = slice_picture(field, axis, slice),
                b = slice_picture(field, axis, (slice + 1) % field.size[axis]);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += (a.pixels[i] - b.pixels[i]).norm();
  return sum / static_cast<double>(a.pixels.size());
}

}  // namespace

void measure_planes(const std::vector<SolidExemplar>& working, const SolidSettings& s,
                    const SolidField& field, std::vector<PlaneMeasures>& out, const Work& work) {
  SliceFamily::Workspace space;
  const int channels = static_cast<int>(field.channel.size());
  for (PlaneMeasures& m : out) {
    const int axis = m.axis;
    const SolidExemplar& e = working[static_cast<std::size_t>(s.plane[static_cast<std::size_t>(axis)])];
    Image image(e.width, e.height, 1, 1);
    image.pixels = e.pixels;
    const int scales = pyramid_scales(
        std::min({e.width, e.height, field.size[kSliceColumns[axis]], field.size[kSliceRows[axis]]}));
    const BandStatistics wanted = measure_bands(image, channels, scales, work.quiet());
    const SliceFamily family(field.size, axis, scales);
    std::vector<double> have(static_cast<std::size_t>(scales) + 2, 0), want(have);
    for (int c = 0; c < channels; ++c) {
      const auto ratio = family.deviations(field.channel[c], wanted.bands[c], space, work.quiet());
      for (std::size_t b = 0; b < ratio.size(); ++b) {
        const auto scale = static_cast<std::size_t>(family.bands()[b].scale);
        const double d = wanted.bands[c][b].deviation;
        have[scale] += ratio[b] * ratio[b] * d * d, want[scale] += d * d;
      }
      std::vector<float> values = field.channel[c];
      const Quantiles got = quantiles_of(values);
      double sum = 0;
      for (std::size_t i = 0; i < got.at.size(); ++i) sum += std::abs(got.at[i] - wanted.values[c].at[i]);
      m.histogram += sum / static_cast<double>(got.at.size()) / channels;
    }
    for (std::size_t b = 0; b < have.size(); ++b)
      m.bands.push_back(want[b] > 0 ? std::sqrt(have[b] / want[b]) : 1);

    const Picture whole = part_of(e, 0, 0, e.width, e.height);
    const Eigen::Array3d g = gradients(whole);
    std::vector<Picture> slices;
    const int n = field.size[axis], most = std::min(n, 16);
    for (int k = 0; k < n; ++k) {
      work.check();
      if (k * most / n == (k + 1) * most / n && n > 32 && k % 2) continue;  // every other one tells enough
      Picture p = slice_picture(field, axis, k);
      const Eigen::Array3d h = gradients(p);
      const double ratio = (h[0] / std::max(h[1], 1e-12)) / std::max(g[0] / std::max(g[1], 1e-12), 1e-12);
      m.stripes_worst = std::max({m.stripes_worst, ratio, 1 / std::max(ratio, 1e-12)});
      if (k * most / n != (k + 1) * most / n) slices.push_back(std::move(p));
    }
    m.patches = patch_distance({whole}, std::move(slices));
    m.patches_floor = std::max(patch_distance({part_of(e, 0, 0, e.width / 2, e.height)},
                                              {part_of(e, e.width / 2, 0, e.width, e.height)}),
                               patch_distance({part_of(e, 0, 0, e.width, e.height / 2)},
                                              {part_of(e, 0, e.height / 2, e.width, e.height)}));
    double inside = 0;
    for (int k = 0; k + 1 < n; ++k) inside += step_across(field, axis, k) / (n - 1);
    m.seam = inside > 0 ? step_across(field, axis, n - 1) / inside : 1;
  }
}

std::vector<PlaneMeasures> measure_copies(const std::vector<MatchFamily>& families) {
  std::vector<PlaneMeasures> out;
  for (const MatchFamily& f : families) {
    PlaneMeasures m;
    m.axis = f.axis;
    double all = 0;
    const std::size_t plane = static_cast<std::size_t>(f.columns) * f.rows;
    for (int s = 0; s < f.slices; ++s) {
      std::size_t same = 0;
      for (int j = 0; j < f.rows; ++j)
        for (int i = 0; i + 1 < f.columns; ++i) {
          const std::uint32_t* at = &f.at[s * plane + static_cast<std::size_t>(j) * f.columns + i];
          same += at[1] == at[0] + 2;
        }
      const double share = static_cast<double>(same) / (static_cast<double>(f.columns - 1) * f.rows);
      m.copied_worst = std::max(m.copied_worst, share), all += share;
    }
    m.copied = all / f.slices;
    out.push_back(std::move(m));
  }
  return out;
}

double directedness(const SolidExemplar& e) {
  const Eigen::Array3d g = gradients(part_of(e, 0, 0, e.width, e.height));
  const double total = g[0] + g[1];
  return total > 0 ? std::sqrt((g[0] - g[1]) * (g[0] - g[1]) + 4 * g[2] * g[2]) / total : 0;
}

double coarseness(const SolidExemplar& e) {
  const auto variance = [](const std::vector<Vec3f>& v) {
    Vec3 mean = Vec3::Zero();
    double square = 0;
    for (const auto& p : v) mean += p.cast<double>(), square += p.cast<double>().squaredNorm();
    const double n = static_cast<double>(v.size());
    return square / n - (mean / n).squaredNorm();
  };
  SolidExemplar plain;
  plain.width = e.width, plain.height = e.height, plain.pixels = e.pixels;
  const double all = variance(e.pixels);
  return all > 0 ? variance(shrink(plain, 8, 8).pixels) / all : 0;
}

}  // namespace terrazzo::solid_optimize
