#include "nodes/sizes/grain_size/grain_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/stereology/profile_columns.h"
#include "nodes/sizes/unfolding/bootstrap.h"

namespace terrazzo::grain_size {
namespace {

using std::numbers::pi;

const char* column_of(Diameter diameter) {
  switch (diameter) {
    case Diameter::MajorAxis:
      return "major_axis";
    case Diameter::MinorAxis:
      return "minor_axis";
    case Diameter::FeretMax:
      return "feret_max";
    case Diameter::FeretMin:
      return "feret_min";
    default:
      return "equivalent_diameter";
  }
}

double counted(const Sizes& s, Weighting weighting, std::size_t i) {
  if (weighting == Weighting::Number) return s.weight[i];
  return s.weight[i] * (weighting == Weighting::Area ? s.area[i] : std::pow(s.diameter[i], 3));
}

const char* name_of(Weighting weighting) {
  return weighting == Weighting::Number ? "by number"
         : weighting == Weighting::Area ? "by area"
                                        : "by weight";
}

// ASTM E112-13, table 6: equations for G in mm.
double number_of_area(double mean_area) { return -3.321928 * std::log10(mean_area) - 2.954; }
double number_of_intercept(double intercept) { return -6.643856 * std::log10(intercept) - 3.288; }

// The values of measures_of, in the order of named_measures.
std::vector<double> values_of(const Sizes& s, const std::vector<double>& counts) {
  std::vector<double> out;
  for (const Weighting weighting : kWeightings) {
    const Curve curve = curve_of(s, weighting, counts);
    for (const int percent : kPercents) out.push_back(quantile(curve, percent / 100.0));
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const double w = counts[i] * counted(s, weighting, i);
      sum += w * s.diameter[i];
      all += w;
    }
    out.push_back(sum / all);
  }
  double number = 0, area = 0, enclosed = 0, perimeter = 0, width = 0, height = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double w = counts[i] * s.weight[i];
    number += w;
    area += w * s.area[i];
    if (!s.outlined) continue;
    enclosed += w * s.enclosed[i];
    perimeter += w * s.perimeter[i];
    width += w * s.width[i];
    height += w * s.height[i];
  }
  out.push_back(number_of_area(area / number));
  if (!s.outlined) return out;
  const double intercept = pi * enclosed / perimeter;
  // A line along x crosses each length of an outline's shadow on the y axis once.
  for (const double v :
       {number_of_intercept(intercept), intercept, 2 * enclosed / height, 2 * enclosed / width})
    out.push_back(v);
  return out;
}

std::vector<Measure> named_measures(const Sizes& s) {
  std::vector<Measure> out;
  for (const Weighting weighting : kWeightings) {
    for (const int percent : kPercents)
      out.push_back({fmt::format("D{} {}", percent, name_of(weighting)), "mm"});
    out.push_back({fmt::format("mean {}", name_of(weighting)), "mm"});
  }
  out.push_back({"ASTM grain size number by area", ""});
  if (s.outlined) {
    out.push_back({"ASTM grain size number by intercepts", ""});
    for (const char* name : {"mean intercept", "mean intercept along x", "mean intercept along y"})
      out.push_back({name, "mm"});
  }
  return out;
}

// Area and length of an outline, and of its shadows on the axes, there and back.
void measure_shadows(const std::vector<Vec2>& loop, Sizes& s) {
  double length = 0;
  Vec2 shadow = Vec2::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 side = loop[(i + 1) % loop.size()] - loop[i];
    length += side.norm();
    shadow += side.cwiseAbs();
  }
  s.enclosed.push_back(loop_area(loop));
  s.perimeter.push_back(length);
  s.width.push_back(shadow.x());
  s.height.push_back(shadow.y());
}

}  // namespace

Sizes sizes_of(const Profiles& profiles, Diameter diameter, const Work& work) {
  const std::vector<ProfileColumn> columns = profile_columns(profiles, work);
  const auto column = std::find_if(columns.begin(), columns.end(),
                                   [&](const ProfileColumn& c) { return c.name == column_of(diameter); });
  const auto unknown = [](double v) { return !(v > 0); };
  if (column == columns.end() || std::any_of(column->values.begin(), column->values.end(), unknown))
    throw Error("no-outlines",
                fmt::format("{} needs the outline of every profile, and some have none", column_of(diameter)),
                "set diameter to equivalent_diameter, or connect profiles with outlines")
        .parameter("diameter");
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i)
    if (profiles.profiles[i].weight > 0) order.push_back(i);
  if (order.empty())
    throw Error("no-profiles", "no profile has a weight: there are none, or all touch the border",
                "use a larger photograph");
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return column->values[a] < column->values[b]; });
  Sizes out;
  out.sections = profiles.sections;
  out.outlined = true;
  for (const std::size_t i : order) {
    const Profile& p = profiles.profiles[i];
    out.diameter.push_back(column->values[i]);
    out.area.push_back(p.area);
    out.weight.push_back(p.weight);
    out.section.push_back(p.section);
    measure_shadows(p.contour, out);
    out.outlined = out.outlined && !p.contour.empty();
  }
  return out;
}

Curve curve_of(const Sizes& s, Weighting weighting, const std::vector<double>& counts) {
  Curve out;
  double below = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!(counts[i] > 0)) continue;
    const double w = counts[i] * counted(s, weighting, i);
    out.diameter.push_back(s.diameter[i]);
    out.share.push_back(below + w / 2);
    below += w;
  }
  for (double& v : out.share) v /= below;
  return out;
}

double quantile(const Curve& curve, double share) {
  const auto above = std::lower_bound(curve.share.begin(), curve.share.end(), share);
  if (above == curve.share.begin()) return curve.diameter.front();
  if (above == curve.share.end()) return curve.diameter.back();
  const std::size_t i = above - curve.share.begin();
  const double t = (share - curve.share[i - 1]) / (curve.share[i] - curve.share[i - 1]);
  return curve.diameter[i - 1] + t * (curve.diameter[i] - curve.diameter[i - 1]);
}

std::vector<Measure> measures_of(const Sizes& s, int repetitions, std::uint64_t seed, const Work& work) {
  std::vector<Measure> out = named_measures(s);
  const std::vector<double> once(s.diameter.size(), 1.0);
  const std::vector<double> values = values_of(s, once);
  std::vector<std::vector<double>> drawn(repetitions);
  work.parallel(repetitions, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      Random random(seed, 1, r);
      const std::vector<double> counts = unfolding::draw_counts(s.section, s.sections, random);
      const bool any = std::any_of(counts.begin(), counts.end(), [](double v) { return v > 0; });
      drawn[r] = values_of(s, any ? counts : once);
    }
  });
  for (std::size_t k = 0; k < out.size(); ++k) {
    Curve repeated;
    for (std::size_t r = 0; r < drawn.size(); ++r) {
      repeated.diameter.push_back(drawn[r][k]);
      repeated.share.push_back((r + 0.5) / repetitions);
    }
    std::sort(repeated.diameter.begin(), repeated.diameter.end());
    out[k].value = values[k];
    out[k].low = quantile(repeated, 0.05);
    out[k].high = quantile(repeated, 0.95);
  }
  return out;
}

CrystalSizes crystal_sizes(const SizeDistribution& distribution) {
  CrystalSizes out;
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t k = 0; k < distribution.classes(); ++k) {
    const double low = distribution.class_edges[k], high = distribution.class_edges[k + 1];
    double number = 0;
    for (const auto& entry : distribution.shapes) number += entry.N_V[k];
    if (!(number > 0)) continue;
    const double size = (low + high) / 2, density = std::log(number / (high - low));
    out.size.push_back(size);
    out.density.push_back(density);
    n += 1;
    x += size;
    y += density;
    xx += size * size;
    xy += size * density;
  }
  if (out.size.size() < 2)
    throw Error("too-few-profiles",
                fmt::format("{} size classes have particles; a slope needs two", out.size.size()),
                "use more size classes, or disconnect distribution");
  out.slope = (n * xy - x * y) / (n * xx - x * x);
  out.intercept = (y - out.slope * x) / n;
  return out;
}

}  // namespace terrazzo::grain_size
