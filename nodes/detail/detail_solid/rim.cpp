#include "nodes/detail/detail_solid/rim.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "nodes/data/indices.h"
#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kBins = 16;             // pixels from the outline, for gains
constexpr int kRimBins = 32;          // the same, for rims
constexpr double kLeastBin = 200;     // pixels in a bin
constexpr int kSizes = 3;             // of profiles whose rims are measured apart
constexpr double kNarrow = 1.3;       // sizes with a smaller ratio count as one
constexpr double kLeastProfile = 60;  // pixels of a profile whose slope counts
constexpr int kDeep = 4;              // pixels from the outline
constexpr std::size_t kEnoughDeep = 4000;

struct Bins {
  std::vector<Vec3> sum;
  std::vector<double> count;
  explicit Bins(int bins) : sum(static_cast<std::size_t>(bins), Vec3::Zero()), count(sum.size(), 0.0) {}
  // Means, up to the last bin with enough pixels. Bins without pixels take the next one's mean.
  std::vector<Vec3f> means() const {
    int n = sum.size();
    while (n > 0 && count[n - 1] < kLeastBin) --n;
    std::vector<Vec3f> out(n);
    for (int i = n; i-- > 0;) {
      const std::size_t k = i;
      if (count[k] >= kLeastBin)
        out[k] = (sum[k] / count[k]).cast<float>();
      else
        out[k] = out[k + 1];
    }
    return out;
  }
};

// Sizes that separate the classes: halfway, by the logarithm, between the sizes at the middle of each third
// of these pixels. Fewer classes if sizes hardly differ.
std::vector<float> size_limits(std::vector<float> sizes) {
  std::vector<float> limits;
  if (sizes.empty()) return limits;
  std::sort(sizes.begin(), sizes.end());
  float last = 0;
  for (int k = 0; k < kSizes; ++k) {
    const float middle = sizes[static_cast<std::size_t>((k + 0.5) / kSizes * (sizes.size() - 1))];
    if (k > 0 && middle < kNarrow * last) continue;
    if (k > 0) limits.push_back(std::sqrt(last * middle));
    last = middle;
  }
  return limits;
}

// Single pixels near outlines count, since blur and sharpening change from one to the next; farther away, a
// rim is smooth and the mean of few pixels is not.
void smooth_far(std::vector<Vec3f>& rim) {
  const std::vector<Vec3f> raw = rim;
  const int n = rim.size();
  for (int i = 0; i < n; ++i) {
    const int reach = std::min({i < 4 ? 0 : i < 10 ? 1 : 3, i, n - 1 - i});
    Vec3f sum = Vec3f::Zero();
    for (int k = i - reach; k <= i + reach; ++k) sum += raw[k];
    rim[i] = sum / static_cast<float>(2 * reach + 1);
  }
}

// Deviations by distance from the nearest outline relative to that of all, from 1/2 to 2. `squares`: their
// sums, in one component.
std::vector<float> relative_gains(const Bins& squares) {
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < squares.sum.size(); ++k) {
    sum += squares.sum[k].x();
    count += squares.count[k];
  }
  std::vector<float> gains;
  for (const Vec3f& m : squares.means())
    gains.push_back(sum > 0 ? std::clamp(std::sqrt(m.x() / static_cast<float>(sum / count)), 0.5f, 2.0f)
                            : 1.0f);
  return gains;
}

}  // namespace

void split_rims(Phases& p, const Labels& labels, Detail& detail) {
  const residual::Outlines outlines = outlines_of(p, labels);
  const std::vector<float> sizes = residual::sizes_of_particles(labels.ids, detail.pixel_size);
  const auto size_at = [&](std::size_t i) { return sizes[outlines.particle[i]]; };
  for (std::size_t phase = 0; phase < detail.phases.size(); ++phase) {
    const auto each = [&](auto&& use) {
      for (std::size_t i = 0; i < p.phase.size(); ++i)
        if (p.phase[i] == static_cast<int>(phase) && size_at(i) > 0) use(i);
    };
    std::vector<float> near;  // sizes at pixels close to outlines
    each([&](std::size_t i) {
      if (outlines.depth[i] < kDeep) near.push_back(size_at(i));
    });
    const std::vector<float> limits = size_limits(std::move(near));
    std::vector<Bins> bins(limits.size() + 1, Bins(kRimBins));
    std::vector<double> logs(bins.size(), 0.0), count(bins.size(), 0.0);
    each([&](std::size_t i) {
      const std::size_t c = std::lower_bound(limits.begin(), limits.end(), size_at(i)) - limits.begin();
      const std::size_t k = bin_of(outlines.depth[i], kRimBins);
      bins[c].sum[k] += p.offset[i].cast<double>();
      ++bins[c].count[k];
      if (outlines.depth[i] < kDeep) {
        logs[c] += std::log(size_at(i));
        ++count[c];
      }
    });
    auto& rims = detail.phases[phase].rims;
    for (std::size_t c = 0; c < bins.size(); ++c) {
      std::vector<Vec3f> offset = bins[c].means();
      if (offset.empty() || count[c] == 0) continue;
      smooth_far(offset);
      rims.push_back({static_cast<float>(std::exp(logs[c] / count[c])), std::move(offset), {}, {}});
    }
    each([&](std::size_t i) { p.offset[i] -= Detail::rim_at(rims, outlines.depth[i], size_at(i)); });
  }
}

void split_gains(Phases& p, const Labels& labels, Detail& detail) {
  const std::vector<float> depth = depths_of(p, labels);
  std::vector<Bins> all(detail.phases.size(), Bins(kBins)), grain = all;
  const auto add = [&](std::vector<Bins>& bins, std::size_t i, const Vec3f& v) {
    Bins& b = bins[p.phase[i]];
    const std::size_t k = bin_of(depth[i], kBins);
    b.sum[k].x() += v.squaredNorm();
    ++b.count[k];
  };
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] >= 0) add(all, i, p.offset[i]);
  for (std::size_t k = 0; k < all.size(); ++k) detail.phases[k].gain = relative_gains(all[k]);
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] < 0) continue;
    const auto& gain = detail.phases[p.phase[i]].gain;
    if (!gain.empty()) p.offset[i] /= gain[bin_of(depth[i], gain.size())];
  }
  const std::size_t w = p.width, h = p.height;
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    const std::size_t x = i % w, y = i / w % h;
    if (p.phase[i] <= 0 || x == 0 || y == 0 || x + 1 == w || y + 1 == h) continue;
    const std::array<std::size_t, 4> neighbors{i - 1, i + 1, i - w, i + w};
    const auto alike = [&](std::size_t j) {
      return p.phase[j] == p.phase[i] && labels.ids[j] == labels.ids[i];
    };
    if (!std::all_of(neighbors.begin(), neighbors.end(), alike)) continue;
    Vec3f mean = Vec3f::Zero();
    for (const std::size_t j : neighbors) mean += p.offset[j] / 4;
    add(grain, i, p.offset[i] - mean);
  }
  for (std::size_t k = 1; k < grain.size(); ++k) detail.phases[k].grain_gain = relative_gains(grain[k]);
}

void keep_deep_pixels(Phases& p, const Labels& labels) {
  const std::vector<float> depth = depths_of(p, labels);
  std::vector<std::array<std::size_t, kDeep + 1>> left(p.pixels.size());  // pixels at least as deep
  for (auto& l : left) l.fill(0);
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    for (int d = 0; p.phase[i] >= 0 && d <= kDeep && depth[i] >= d; ++d) ++left[p.phase[i]][d];
  std::vector<int> least(left.size(), kDeep);
  for (std::size_t k = 0; k < left.size(); ++k) {
    while (least[k] > 0 && left[k][least[k]] < kEnoughDeep) --least[k];
    if (least[k] > 0) p.pixels[k] = left[k][least[k]];
  }
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] >= 0 && depth[i] < least[p.phase[i]]) p.phase[i] = -1;
}

std::vector<double> split_slopes(Phases& p, const Labels& labels) {
  struct Fit {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, v = 0, vx = 0, vy = 0;
    double mx = 0, my = 0, gx = 0, gy = 0;
    int group = 0;
  };
  std::vector<Fit> fits(labels.count());
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < p.phase.size(); ++i)
      if (p.phase[i] > 0) {
        const std::size_t in = i % p.plane();
        use(fits[static_cast<std::size_t>(labels.ids[i]) - 1], i, static_cast<double>(in % p.width),
            static_cast<double>(in / p.width));
      }
  };
  each([&](Fit& f, std::size_t i, double x, double y) {
    const double v = p.offset[i].mean();
    ++f.n;
    f.x += x;
    f.y += y;
    f.xx += x * x;
    f.xy += x * y;
    f.yy += y * y;
    f.v += v;
    f.vx += v * x;
    f.vy += v * y;
    f.group = p.phase[i];
  });
  // Of each group: squared slope times squared radius, and the profile's pixels.
  std::vector<std::vector<std::pair<double, double>>> steepness(p.group_color.size());
  for (Fit& f : fits) {
    if (f.n < kLeastProfile) continue;
    f.mx = f.x / f.n;
    f.my = f.y / f.n;
    const double xx = f.xx / f.n - f.mx * f.mx, xy = f.xy / f.n - f.mx * f.my, yy = f.yy / f.n - f.my * f.my;
    const double vx = f.vx / f.n - f.mx * f.v / f.n, vy = f.vy / f.n - f.my * f.v / f.n;
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-6)) continue;
    f.gx = (vx * yy - vy * xy) / det;
    f.gy = (vy * xx - vx * xy) / det;
    steepness[f.group - 1].emplace_back((f.gx * f.gx + f.gy * f.gy) * f.n / std::numbers::pi, f.n);
  }
  each([&](const Fit& f, std::size_t i, double x, double y) {
    p.offset[i] -= Vec3f::Constant(static_cast<float>(f.gx * (x - f.mx) + f.gy * (y - f.my)));
  });
  // A few profiles that contain a shadow or two stones count as if their slope were twice the median by area.
  std::vector<double> out;
  for (auto& of_group : steepness) {
    std::sort(of_group.begin(), of_group.end());
    double all = 0, below = 0, sum = 0;
    for (const auto& [square, pixels] : of_group) all += pixels;
    std::size_t k = 0;
    while (k < of_group.size() && (below += of_group[k].second) < all / 2) ++k;
    for (const auto& [square, pixels] : of_group) sum += pixels * std::min(square, 4 * of_group[k].first);
    out.push_back(all > 0 ? std::sqrt(sum / all / 2) : 0);
  }
  return out;
}

}  // namespace terrazzo::detail_solid
