// Compares images as textures. Tolerances are the differences between two halves of the reference.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/band_statistics.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/phase_statistics.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/common/texture/texture_measures.h"
#include "nodes/compare/compare/comparison.h"

namespace terrazzo::compare {
namespace {

constexpr int kLeastSide = 48;  // pixels; halves still need patches and bands
constexpr int kSections = 8;
constexpr int kReach = 32;  // pixels; longest distance of two-point correlation and lineal path

// Converts to Oklab, stored in an Image. Keeps at most kSections sections, evenly spaced.
Image oklab(const Image& in) {
  const int sections = std::min(in.sections, kSections);
  Image out(in.width, in.height, sections, in.pixel_size);
  for (int s = 0; s < sections; ++s) {
    const int from = static_cast<std::int64_t>(s) * in.sections / sections;
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x) out.at(x, y, s) = linear_to_oklab(in.at(x, y, from));
  }
  return out;
}

Image cut(const Image& in, int x0, int y0, int width, int height) {
  Image out(width, height, in.sections, in.pixel_size);
  for (int s = 0; s < in.sections; ++s)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) out.at(x, y, s) = in.at(x0 + x, y0 + y, s);
  return out;
}

// An image and its left, right, upper and lower half.
struct Texture {
  Image whole;
  std::array<Image, 4> half;
  explicit Texture(const Image& image) : whole(oklab(image)) {
    const int w = image.width, h = image.height;
    half = {cut(whole, 0, 0, w / 2, h), cut(whole, w - w / 2, 0, w / 2, h), cut(whole, 0, 0, w, h / 2),
            cut(whole, 0, h - h / 2, w, h / 2)};
  }
};

using Values = std::vector<double>;

// Summaries of a and b, the measures between them, and the same measures between halves of the reference a
// (the larger of left–right and top–bottom).
template <class Summary>
struct Measured {
  Summary a, b;
  Values found, floor;
};
template <class Summary>
Measured<Summary> measured(const Texture& a, const Texture& b, const std::function<Summary(const Image&)>& of,
                           const std::function<Values(const Summary&, const Summary&)>& between) {
  Measured<Summary> m{of(a.whole), of(b.whole), {}, {}};
  m.found = between(m.a, m.b);
  m.floor.assign(m.found.size(), 0);
  for (std::size_t k = 0; k < 4; k += 2) {
    const Values v = between(of(a.half[k]), of(a.half[k + 1]));
    for (std::size_t i = 0; i < v.size(); ++i) m.floor[i] = std::max(m.floor[i], v[i]);
  }
  return m;
}

void compare_bands(const Texture& a, const Texture& b, Comparison& out, const Work& work) {
  int side = 1 << 20;
  for (const Texture* t : {&a, &b}) side = std::min({side, t->whole.width / 2, t->whole.height / 2});
  const int scales = pyramid_scales(side);
  // Per scale, the lightness values in its bands of all directions, finest scale first.
  struct Scale {
    std::vector<Quantiles> band;
    double deviation = 0;
  };
  using Scales = std::vector<Scale>;
  const auto of = [&](const Image& image) {
    work.check();
    const BandStatistics s = measure_bands(image, 1, scales, work.quiet());
    const auto bands = pyramid_bands(s.width, s.height, scales);
    Scales all(static_cast<std::size_t>(scales) + 1);
    for (std::size_t k = 0; k < bands.size(); ++k) {
      if (bands[k].scale > scales) continue;
      Scale& scale = all[bands[k].scale];
      scale.band.push_back(s.bands[0][k]);
      scale.deviation = std::hypot(scale.deviation, s.bands[0][k].deviation);
    }
    return all;
  };
  const auto m = measured<Scales>(a, b, of, [](const Scales& x, const Scales& y) {
    constexpr int kSteps = 256;
    Values v;
    for (std::size_t s = 0; s < x.size(); ++s) {
      double sum = 0;
      for (std::size_t k = 0; k < x[s].band.size(); ++k)
        for (int i = 0; i < kSteps; ++i) {
          const double u = (i + 0.5) / kSteps;
          sum += std::abs(x[s].band[k].of(u) - y[s].band[k].of(u)) / std::max(1e-9, x[s].band[k].deviation);
        }
      v.push_back(sum / kSteps / x[s].band.size());
    }
    for (std::size_t s = 0; s < x.size(); ++s) v.push_back(std::abs(x[s].deviation - y[s].deviation));
    return v;
  });
  double worst = 0, least = 1e300, most = 0;
  PlotSeries left, right;
  Plot plot;
  plot.title = "Deviation of each band";
  plot.x_label = "scale, fine to coarse";
  plot.y_label = "Oklab L";
  for (std::size_t s = 0; s < m.a.size(); ++s) {
    const double ratio = m.b[s].deviation / std::max(1e-9, m.a[s].deviation);
    worst = std::max(worst, m.found[s]);
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    const std::string name = s == 0 ? "finest" : fmt::format("scale {}", s);
    out.numbers.push_back({"bands", name + ", deviation", "Oklab L", 0, 0, m.a[s].deviation, m.b[s].deviation,
                           m.floor[m.a.size() + s]});
    out.numbers.push_back({"bands", name + ", W1/σ", "", 0, 0, 0, m.found[s], m.floor[s]});
    left.x.push_back(static_cast<double>(s));
    left.y.push_back(m.a[s].deviation);
    right.x.push_back(static_cast<double>(s));
    right.y.push_back(m.b[s].deviation);
    left.low.push_back(std::max(0.0, m.a[s].deviation - m.floor[m.a.size() + s]));
    left.high.push_back(m.a[s].deviation + m.floor[m.a.size() + s]);
  }
  left.kind = right.kind = PlotSeries::Kind::Bars;
  right.color = 1;
  plot.series = {left, right};
  out.plots.push_back(plot);
  out.metrics["band_distance"] = worst;
  out.metrics["band_ratio_least"] = least;
  out.metrics["band_ratio_most"] = most;
}

std::vector<PatchPicture> pictures_of(const Image& lab) {
  std::vector<PatchPicture> all;
  for (int s = 0; s < lab.sections; ++s)
    all.push_back({lab.width,
                   lab.height,
                   {&lab.at(0, 0, s), &lab.at(0, 0, s) + std::size_t(lab.width) * lab.height},
                   {}});
  return all;
}

void compare_patches(const Texture& a, const Texture& b, Comparison& out, const Work& work) {
  using Pictures = std::vector<PatchPicture>;
  const auto m = measured<Pictures>(a, b, pictures_of, [&](const Pictures& x, const Pictures& y) {
    work.check();
    return Values{patch_distance(x, y, 0, work.quiet()), nearest_patch(x, y, 0.95, work.quiet()),
                  nearest_patch(y, x, 0.95, work.quiet())};
  });
  const char* items[] = {"sliced Wasserstein distance", "nearest in b, 95th percentile of a's",
                         "nearest in a, 95th percentile of b's"};
  for (std::size_t k = 0; k < 3; ++k)
    out.numbers.push_back({"patches", items[k], "Oklab", 0, 0, 0, m.found[k], m.floor[k]});
  out.metrics["patch_distance"] = m.found[0];
  out.metrics["patch_distance_floor"] = m.floor[0];
  out.metrics["nearest_patch_of_a"] = m.found[1];
  out.metrics["nearest_patch_of_b"] = m.found[2];
}

std::vector<Phase> darker_half(const Image& lab) {
  std::vector<float> light;
  for (const Vec3f& c : lab.pixels) light.push_back(c[0]);
  const float middle = median(std::move(light));
  std::vector<Phase> all;
  for (int s = 0; s < lab.sections; ++s) {
    Phase p{lab.width, lab.height, {}};
    for (int y = 0; y < lab.height; ++y)
      for (int x = 0; x < lab.width; ++x) p.in.push_back(lab.at(x, y, s)[0] < middle);
    all.push_back(std::move(p));
  }
  return all;
}

void compare_phases(const Texture& a, const Texture& b, const CompareOptions& choice, Comparison& out,
                    const Work& work) {
  const auto of = [&](const Image& lab) {
    work.check();
    return phase_statistics(darker_half(lab), kReach < std::min(lab.width, lab.height)
                                                  ? kReach
                                                  : std::min(lab.width, lab.height) - 1);
  };
  const auto largest = [](const Values& x, const Values& y) {
    double d = 0;
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) d = std::max(d, std::abs(x[i] - y[i]));
    return d;
  };
  const auto m = measured<PhaseStatistics>(a, b, of, [&](const auto& x, const auto& y) {
    return Values{largest(x.two_point, y.two_point), largest(x.lineal_path, y.lineal_path)};
  });
  const auto add = [&](const char* measure, std::size_t k, const Values& va, const Values& vb,
                       const char* title) {
    out.numbers.push_back({measure, "largest difference", "", 0, 0, 0, m.found[k], m.floor[k]});
    out.metrics[std::string(measure) + "_difference"] = m.found[k];
    Plot plot;
    plot.title = title;
    plot.x_label = "pixels";
    plot.y_label = "share";
    for (const Values* v : {&va, &vb}) {
      PlotSeries s;
      for (std::size_t r = 0; r < v->size(); ++r) {
        s.x.push_back(static_cast<double>(r));
        s.y.push_back((*v)[r]);
      }
      s.color = v == &vb;
      plot.series.push_back(s);
    }
    out.plots.push_back(plot);
  };
  if (choice.two_point)
    add("two_point", 0, m.a.two_point, m.b.two_point, "Two-point correlation, darker half");
  if (choice.lineal_path) add("lineal_path", 1, m.a.lineal_path, m.b.lineal_path, "Lineal path, darker half");
}

// Mean step across the wrap / mean step inside: about 1 if the image is tileable.
double seam_ratio(const Image& lab, int axis) {
  const int n = axis == 0 ? lab.width : lab.height, m = axis == 0 ? lab.height : lab.width;
  double across = 0, inside = 0;
  const auto at = [&](int i, int j, int s) { return axis == 0 ? lab.at(i, j, s) : lab.at(j, i, s); };
  for (int s = 0; s < lab.sections; ++s)
    for (int j = 0; j < m; ++j) {
      across += (at(0, j, s) - at(n - 1, j, s)).norm();
      for (int i = 0; i + 1 < n; ++i) inside += (at(i + 1, j, s) - at(i, j, s)).norm() / (n - 1);
    }
  return inside > 0 ? across / inside : 1;
}

}  // namespace

void compare_textures(const Image& a, const Image& b, const CompareOptions& choice, Comparison& out,
                      const Work& work) {
  if (!choice.bands && !choice.patches && !choice.two_point && !choice.lineal_path && !choice.seam) return;
  if (std::min({a.width, a.height, b.width, b.height}) < kLeastSide) {
    out.warnings.push_back(
        fmt::format("images smaller than {} pixels per side are compared only by color", kLeastSide));
    return;
  }
  if (std::abs(a.pixel_size / b.pixel_size - 1) > 0.01)
    out.warnings.push_back(fmt::format(
        "a pixel is {:.4g} mm in a and {:.4g} mm in b: textures are compared pixel by pixel, not by length",
        a.pixel_size, b.pixel_size));
  const Texture ta(a), tb(b);
  if (choice.bands) compare_bands(ta, tb, out, work);
  if (choice.patches) compare_patches(ta, tb, out, work);
  if (choice.two_point || choice.lineal_path) compare_phases(ta, tb, choice, out, work);
  if (choice.seam)
    for (int axis = 0; axis < 2; ++axis) {
      const double sa = seam_ratio(ta.whole, axis), sb = seam_ratio(tb.whole, axis);
      out.numbers.push_back({"seam", axis == 0 ? "across x" : "across y", "", 0, 0, sa, sb, NAN});
      out.metrics[axis == 0 ? "seam_x" : "seam_y"] = sb;
    }
}

}  // namespace terrazzo::compare
