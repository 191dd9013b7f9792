#include "nodes/detail/detail_solid/rim.h"

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/detail/detail_solid/broad.h"
#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kBins = 16;             // pixels from the outline, for gains
constexpr int kRimBins = 32;          // the same, for rims
constexpr double kLeastBin = 200;     // pixels in a bin
constexpr int kSizes = 3;             // of profiles whose rims are measured apart
constexpr double kNarrow = 1.3;       // sizes with a smaller ratio count as one
constexpr double kLeastProfile = 60;  // pixels of a profile whose slope and contrast count
constexpr int kDeep = 4;              // pixels from the outline
constexpr float kBlurred = 2.5f;      // the same, within which pixels do not tell the contrast of a profile
constexpr std::size_t kEnoughDeep = 4000;
constexpr double kLeastContrast = 0.03;
constexpr double kGrainArea = 10, kBroadArea = 200;  // pixels that count as one sample of a deviation
constexpr double kPrior = 4;                         // samples of the group that are added to a profile's
constexpr int kStep = 8;                             // pixels on each side of an outline

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

std::vector<float> depths_of(const Phases& p, const Labels& labels) { return outlines_of(p, labels).depth; }

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

// The smallest value that this share of the weight does not exceed. Sorts the values.
float quantile_by_weight(std::vector<std::pair<float, double>>& values, double share) {
  std::sort(values.begin(), values.end());
  double all = 0, below = 0;
  for (const auto& [value, weight] : values) all += weight;
  for (const auto& [value, weight] : values)
    if ((below += weight) >= share * all) return value;
  return values.back().first;
}

// Bin of a depth among n.
std::size_t bin_of(float depth, std::size_t n) { return std::min<std::size_t>(depth, n - 1); }

// A profile in which hues vary far more than in the others of its group holds two stones, or a stone and
// soil. Its stones would get patches of several hues, so its contrasts of chroma are limited: to 1.3 times
// the median by area, or to what a fifth of the area exceeds.
void limit_chroma(const Detail& detail, std::size_t groups, std::vector<Eigen::Vector2f>& of_profile) {
  for (std::size_t g = 1; g <= groups; ++g) {
    std::vector<std::pair<float, double>> contrast;  // with the profile's area
    for (std::size_t k = 0; k < detail.profile_group.size(); ++k)
      if (detail.profile_group[k] == static_cast<std::int32_t>(g))
        contrast.emplace_back(of_profile[k].y(), std::pow(double{detail.profile_size[k]}, 2));
    if (contrast.empty()) continue;
    const float limit = std::max(1.3f * quantile_by_weight(contrast, 0.5), quantile_by_weight(contrast, 0.8));
    for (std::size_t k = 0; k < detail.profile_group.size(); ++k)
      if (detail.profile_group[k] == static_cast<std::int32_t>(g))
        of_profile[k].y() = std::min(of_profile[k].y(), limit);
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

// Squares of the mean of the channels, and of the rest. One crack or speck of dirt would dominate the mean
// square of a small profile, so the upper quartile of the squares measures its grain.
struct GrainSquares {
  std::vector<float> gray, chroma;
  void add(const Vec2& squares) {
    gray.push_back(squares[0]);
    chroma.push_back(squares[1]);
  }
  Vec2 value() {
    constexpr double kRank = 0.75;
    if (gray.empty()) return Vec2::Zero();
    const std::size_t rank = kRank * (gray.size() - 1);
    return {at_rank(gray, rank), at_rank(chroma, rank)};
  }
};

Vec2 squares_of(const Vec3f& offset) {
  const double mean = offset.mean();
  return Vec2(3 * mean * mean, std::max(0.0, offset.squaredNorm() - 3 * mean * mean));
}

// What contrasts are measured from, of a profile or of a group.
struct ContrastSum {
  double pixels = 0, count = 0;  // all, and those whose grain and broad part are summed
  GrainSquares of_grain, of_finest;
  Vec2 grain = Vec2::Zero(), finest = Vec2::Zero(), broad = Vec2::Zero();
  std::size_t group = 0;

  void add(const Vec3f& grain_offset, const Vec3f& finest_offset, const Vec3f& broad_offset) {
    ++count;
    of_grain.add(squares_of(grain_offset));
    of_finest.add(squares_of(finest_offset));
    broad += squares_of(broad_offset);
  }
  void finish() {
    grain = count * of_grain.value();
    finest = count * of_finest.value();
    of_grain = {};
    of_finest = {};
  }
};

// Difference from the mean of the neighbors in the profile. Only deep pixels are used, so all of these are
// in the same section.
Vec3f finest_offset(const Phases& p, const Labels& labels, const std::vector<Vec3f>& offset, std::size_t i) {
  Vec3f sum = Vec3f::Zero();
  float count = 0;
  for (const std::size_t j : {i - 1, i + 1, i - p.width, i + p.width})
    if (j < p.phase.size() && labels.ids[j] == labels.ids[i] && p.phase[j] > 0) {
      sum += offset[j];
      ++count;
    }
  return count > 0 ? Vec3f(offset[i] - sum / count) : Vec3f::Zero();
}

struct ContrastSums {
  std::vector<ContrastSum> profile, group;
};

// Divides the grain by its gain near outlines, and sums it over profiles and groups.
ContrastSums sum_contrasts(const Phases& p, const Labels& labels, const Detail& detail,
                           const std::vector<Vec3f>& broad, Phases& grain) {
  ContrastSums sums{std::vector<ContrastSum>(static_cast<std::size_t>(labels.count())),
                    std::vector<ContrastSum>(p.group_color.size())};
  const std::vector<Vec3f> before = grain.offset;
  const std::vector<float> depth = depths_of(p, labels);
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] <= 0) continue;
    if (const auto& gain = detail.phases[p.phase[i]].grain_gain; !gain.empty())
      grain.offset[i] /= gain[bin_of(depth[i], gain.size())];
    ContrastSum& s = sums.profile[static_cast<std::size_t>(labels.ids[i]) - 1];
    s.group = static_cast<std::size_t>(p.phase[i]) - 1;
    ++s.pixels;
    if (depth[i] < kBlurred) continue;  // the blur of the outline counts as grain there
    const Vec3f finest = finest_offset(p, labels, before, i);
    for (ContrastSum* sum : {&s, &sums.group[s.group]}) sum->add(grain.offset[i], finest, broad[i]);
  }
  for (auto* of : {&sums.profile, &sums.group})
    for (ContrastSum& s : *of) s.finish();
  return sums;
}

// A profile counts as `samples` independent ones; those of a group's mean deviation are added to them.
Eigen::Vector2f relative_contrast(const Vec2& own, double count, const Vec2& all, double of_all,
                                  double samples) {
  Eigen::Vector2f out(1, 1);
  for (int a = 0; a < 2; ++a)
    if (all[a] > 1e-9 * all.sum()) {
      const double ratio = own[a] / count / (all[a] / of_all);
      out[a] = std::clamp(std::sqrt((samples * ratio + kPrior) / (samples + kPrior)), kLeastContrast, 3.0);
    }
  return out;
}

Eigen::Vector2f grain_contrast(const ContrastSum& s, const ContrastSum& g) {
  Eigen::Vector2f out(1, 1);
  const double samples = s.count / kGrainArea;
  if (s.count > 0 && g.grain.sum() > 0) out = relative_contrast(s.grain, s.count, g.grain, g.count, samples);
  // The gradient of a dark spot counts as grain, so the contrast of the finest grain limits that of all
  // grain.
  if (s.count > 0 && g.finest.sum() > 0) {
    const auto finest = relative_contrast(s.finest, s.count, g.finest, g.count, samples);
    out = out.cwiseMin(finest.cwiseMax(1.0f));
  }
  return out;
}

Eigen::Vector2f broad_contrast(const ContrastSum& s, const ContrastSum& g) {
  if (!(s.count > 0 && g.broad.sum() > 0)) return {1, 1};
  return relative_contrast(s.broad, s.count, g.broad, g.count, s.count / kBroadArea);
}

Vec3f without_contrast(const Vec3f& offset, const Eigen::Vector2f& contrast) {
  const Vec3f gray = Vec3f::Constant(offset.mean());
  return gray / contrast.x() + (offset - gray) / contrast.y();
}

// The step of colors across outlines, in bins by the distance from the nearest outline.
struct OutlineSteps {
  std::array<double, 2 * kStep> up{}, down{};
};

// Adds one section. `flat` and `count` are sums of colors and pixels, of profiles and of each section's
// binder.
void add_outline_steps(const Image& image, const Labels& labels, int section, std::vector<Vec3>& flat,
                       std::vector<double>& count, OutlineSteps& steps) {
  const int w = image.width, h = image.height;
  const std::size_t plane = pixels_in(w, h);
  std::vector<Vec3f> encoded(plane);
  flat[0].setZero();
  count[0] = 0;
  cv::Mat particles(h, w, CV_8U), binder(h, w, CV_8U);
  const auto id = [&](std::size_t i) { return labels.ids[section * plane + i]; };
  for (std::size_t i = 0; i < plane; ++i) {
    encoded[i] = linear_to_srgb(image.pixels[section * plane + i].cwiseMax(0.0f));
    flat[id(i)] += encoded[i].cast<double>();
    ++count[id(i)];
    particles.data[i] = id(i) > 0 ? 0 : 255;
    binder.data[i] = id(i) > 0 ? 255 : 0;
  }
  cv::Mat outside, inside, nearest;
  cv::distanceTransform(particles, outside, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  cv::distanceTransform(binder, inside, cv::DIST_L2, cv::DIST_MASK_5);
  std::vector<std::int32_t> owner(plane + 1, 0);  // label of each number in `nearest`
  for (std::size_t i = 0; i < plane; ++i)
    if (id(i) > 0) owner[reinterpret_cast<const std::int32_t*>(nearest.data)[i]] = id(i);
  for (std::size_t i = 0; i < plane; ++i) {
    const float out = reinterpret_cast<const float*>(outside.data)[i],
                in = reinterpret_cast<const float*>(inside.data)[i];
    const double d = id(i) > 0 ? in - 0.5 : 0.5 - out;  // positive within particles
    const int bin = round_down(d) + kStep;
    if (bin < 0 || bin >= 2 * kStep) continue;
    const std::size_t k = owner[reinterpret_cast<const std::int32_t*>(nearest.data)[i]];
    if (!(count[k] > 0) || !(count[0] > 0)) continue;
    const Vec3 base = flat[0] / count[0], rise = flat[k] / count[k] - base;
    steps.up[bin] += (encoded[i].cast<double>() - base).dot(rise);
    steps.down[bin] += rise.squaredNorm();
  }
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

void split_contrasts(Phases& p, const Image& image, const Labels& labels, Detail& detail, const Work& work) {
  Phases grain = p;
  const std::vector<Vec3f> broad = split_broad(grain, labels, work.quiet());
  const ContrastSums sums = sum_contrasts(p, labels, detail, broad, grain);
  const std::vector<float> size = residual::sizes_of_particles(labels.ids, image.pixel_size);
  std::vector<Eigen::Vector2f> of_grain(sums.profile.size(), Eigen::Vector2f(1, 1)), of_broad = of_grain;
  for (std::size_t k = 0; k < sums.profile.size(); ++k) {
    const ContrastSum& s = sums.profile[k];
    const ContrastSum& g = sums.group[s.group];
    if (s.pixels < kLeastProfile || !((g.grain + g.broad).sum() > 0)) continue;
    of_grain[k] = grain_contrast(s, g);
    of_broad[k] = broad_contrast(s, g);
    detail.profile_color.push_back(p.profile_color[k]);
    detail.profile_group.push_back(static_cast<std::int32_t>(s.group) + 1);
    detail.profile_contrast.push_back(of_grain[k]);
    detail.profile_broad.push_back(of_broad[k]);
    detail.profile_size.push_back(size[k + 1]);
  }
  limit_chroma(detail, p.group_color.size(), detail.profile_contrast);
  limit_chroma(detail, p.group_color.size(), detail.profile_broad);
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] > 0) {
      const std::size_t k = static_cast<std::size_t>(labels.ids[i]) - 1;
      p.offset[i] = without_contrast(grain.offset[i], of_grain[k]) + without_contrast(broad[i], of_broad[k]);
    }
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

double outline_softness(const Image& image, const Labels& labels) {
  std::vector<Vec3> flat(labels.count() + 1, Vec3::Zero());
  std::vector<double> count(flat.size(), 0.0);
  OutlineSteps steps;
  for (int section = 0; section < image.sections; ++section)
    add_outline_steps(image, labels, section, flat, count, steps);
  std::array<double, 2 * kStep> step{};
  for (std::size_t k = 0; k < step.size(); ++k) {
    if (!(steps.down[k] > 0)) return 0;
    step[k] = steps.up[k] / steps.down[k];
  }
  const double low = step.front(), high = step.back();
  if (!(high - low > 0.1)) return 0;  // particles and binder cannot be told by color
  // From where a quarter of the step is left behind to three quarters, around its middle.
  const auto share = [&](std::size_t k) { return (step[k] - low) / (high - low); };
  std::size_t middle = 1;
  while (middle + 1 < step.size() && share(middle) < 0.5) ++middle;
  const auto crossing = [&](double level) {
    std::size_t k = middle;
    if (level < 0.5)
      while (k > 1 && share(k - 1) > level) --k;
    else
      while (k + 1 < step.size() && share(k) < level) ++k;
    const double from = share(k - 1), to = share(k);
    return static_cast<double>(k) - 1 + std::clamp((level - from) / std::max(to - from, 1e-6), 0.0, 1.0);
  };
  const double sigma = (crossing(0.75) - crossing(0.25)) / 1.349;
  return std::clamp(std::sqrt(std::max(0.0, sigma * sigma - 1.0 / 6)), 0.0, 3.0);
}

}  // namespace terrazzo::detail_solid
