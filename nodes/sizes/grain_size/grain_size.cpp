#include "nodes/sizes/grain_size/grain_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/sizes/unfolding/bootstrap.h"

namespace terrazzo::grain_size {
namespace {

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

// ASTM E112-13, table 6: equations for G in mm.
double number_of_area(double mean_area) { return -3.321928 * std::log10(mean_area) - 2.954; }
double number_of_intercept(double intercept) { return -6.643856 * std::log10(intercept) - 3.288; }

// Percentiles and the means of one weighting; `counts`: how often each profile appears.
void add_sizes(const Sizes& s, const std::vector<double>& amount, const std::vector<double>& counts,
               std::vector<double>& out) {
  double all = 0, sum = 0, logs = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    all += counts[i] * amount[i];
    sum += counts[i] * amount[i] * s.diameter[i];
    logs += counts[i] * amount[i] * std::log(s.diameter[i]);
  }
  double below = 0, share = 0, diameter = 0;  // of the last profile that appears
  std::size_t k = 0;
  for (std::size_t i = 0; i < counts.size() && k < kPercents.size(); ++i) {
    if (!(counts[i] > 0)) continue;
    const double next = (below + counts[i] * amount[i] / 2) / all;
    for (; k < kPercents.size() && kPercents[k] / 100.0 <= next; ++k) {
      const double t = (kPercents[k] / 100.0 - share) / (next - share);
      out.push_back(below == 0 ? s.diameter[i] : diameter + t * (s.diameter[i] - diameter));
    }
    share = next;
    diameter = s.diameter[i];
    below += counts[i] * amount[i];
  }
  for (; k < kPercents.size(); ++k) out.push_back(diameter);
  out.push_back(sum / all);
  out.push_back(std::exp(logs / all));
}

// The values of measures_of, in the order of named_measures.
std::vector<double> values_of(const Sizes& s, const std::vector<double>& counts) {
  std::vector<double> out;
  for (const auto& amount : s.amounts) add_sizes(s, amount, counts, out);
  double number = 0, area = 0, enclosed = 0, width = 0, height = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double w = counts[i] * s.weight[i];
    number += w;
    area += w * s.area[i];
    if (!s.outlined) continue;
    enclosed += w * s.enclosed[i];
    width += w * s.width[i];
    height += w * s.height[i];
  }
  out.push_back(number_of_area(area / number));
  if (!s.outlined) return out;
  // Lines along x cross the shadow of an outline on the y axis.
  const double intercept = 4 * enclosed / (width + height);
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
    for (const char* mean : {"mean", "geometric mean"})
      out.push_back({fmt::format("{} {}", mean, name_of(weighting)), "mm"});
  }
  out.push_back({"ASTM grain size number by area", ""});
  if (s.outlined) {
    out.push_back({"ASTM grain size number by intercepts", ""});
    for (const char* name : {"mean intercept", "mean intercept along x", "mean intercept along y"})
      out.push_back({name, "mm"});
  }
  return out;
}

// Area of an outline, and lengths of its shadows on the axes, there and back.
void measure_shadows(const std::vector<Vec2>& loop, Sizes& s) {
  Vec2 shadow = Vec2::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) shadow += (loop[(i + 1) % loop.size()] - loop[i]).cwiseAbs();
  s.enclosed.push_back(loop_area(loop));
  s.width.push_back(shadow.x());
  s.height.push_back(shadow.y());
}

}  // namespace

const char* name_of(Weighting weighting) {
  return weighting == Weighting::Number ? "by number"
         : weighting == Weighting::Area ? "by area"
                                        : "by weight";
}

Sizes sizes_of(const Profiles& profiles, const std::vector<ProfileColumn>& columns, Diameter diameter) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i)
    if (profiles.profiles[i].weight > 0) order.push_back(i);
  if (order.empty())
    throw Error("no-profiles", "no profile has a weight: there are none, or all touch the border",
                "use a larger photograph");
  const auto column = std::find_if(columns.begin(), columns.end(),
                                   [&](const ProfileColumn& c) { return c.name == column_of(diameter); });
  for (const std::size_t i : order) {
    if (column == columns.end() || std::isnan(column->values[i]))
      throw Error("no-outlines",
                  fmt::format("{} needs the outline of every profile, but profile {} has none",
                              column_of(diameter), i),
                  "set diameter to equivalent_diameter, or connect profiles with outlines")
          .parameter("diameter");
    if (!(column->values[i] > 0))
      throw Error("bad-profile", fmt::format("profile {} has no area", i), "remove it from the profiles");
  }
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
    out.amounts[0].push_back(p.weight);
    out.amounts[1].push_back(p.weight * p.area);
    out.amounts[2].push_back(p.weight * std::pow(out.diameter.back(), 3));
    measure_shadows(p.contour, out);
    out.outlined = out.outlined && !p.contour.empty();
  }
  return out;
}

Curve curve_of(const Sizes& s, Weighting weighting) {
  Curve out{s.diameter, {}};
  double below = 0;
  for (const double amount : s.amounts[static_cast<std::size_t>(weighting)]) {
    out.share.push_back(below + amount / 2);
    below += amount;
  }
  for (double& v : out.share) v /= below;
  return out;
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
  std::vector<double> repeated(drawn.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    for (std::size_t r = 0; r < drawn.size(); ++r) repeated[r] = drawn[r][k];
    out[k].value = values[k];
    out[k].low = unfolding::quantile(repeated, 0.05);
    out[k].high = unfolding::quantile(repeated, 0.95);
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
