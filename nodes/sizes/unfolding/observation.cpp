#include "nodes/sizes/unfolding/observation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "graph/diagnostic.h"

namespace terrazzo::unfolding {
namespace {

void check(const Profiles& p) {
  if (p.profiles.empty())
    throw Error("no-profiles", "there are no profiles to unfold",
                "check the segmentation, or lower its smallest area");
  for (std::size_t i = 0; i < p.profiles.size(); ++i) {
    const Profile& q = p.profiles[i];
    const auto bad = [&](const std::string& what, double value) {
      throw Error(
          "bad-profiles",
          fmt::format("profile {} of {} has an invalid {}: {:.4g}", i, p.profiles.size(), what, value),
          "remove it from the data");
    };
    if (!(q.area > 0) || !std::isfinite(q.area)) bad("area", q.area);
    if (!(q.weight >= 0) || !std::isfinite(q.weight)) bad("weight", q.weight);
    if (q.cls < 0) bad("class", q.cls);
  }
  if (!(p.observed_area >= 0) || !std::isfinite(p.observed_area))
    throw Error("bad-profiles",
                fmt::format("the observed area must be 0 mm² or more; it is {} mm²", p.observed_area),
                "correct the observed area, or set it to 0 if it is unknown");
  if (!(p.area_fraction >= 0 && p.area_fraction <= 1))
    throw Error("bad-profiles",
                fmt::format("the area fraction must be between 0 and 1; it is {}", p.area_fraction),
                "correct the area fraction, or set it to 0 if it is unknown");
}

}  // namespace

Observations observe(const Profiles& profiles, Border border, double smallest_visible, double area_fraction) {
  check(profiles);
  Observations o;
  o.sections = std::max(1, profiles.sections);
  int classes = std::max(1, profiles.classes);
  for (const Profile& p : profiles.profiles) classes = std::max(classes, p.cls + 1);
  o.classes.resize(classes);

  std::vector<double> all_area(classes, 0.0), counted_area(classes, 0.0);
  double all = 0, counted = 0;
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    all_area[p.cls] += p.area;
    all += p.area;
    const double weight = border == Border::Weights                      ? p.weight
                          : border == Border::Inside && p.touches_border ? 0
                                                                         : 1;
    if (!(weight > 0)) {
      ++o.cut;
      continue;
    }
    counted_area[p.cls] += weight * p.area;
    counted += weight * p.area;
    const double size = std::sqrt(4 * (profiles.view == View::Surface ? std::max(p.area, p.whole) : p.area) /
                                  std::numbers::pi);
    if (size < smallest_visible) {
      ++o.hidden;
      continue;
    }
    Observation& c = o.classes[p.cls];
    c.size.push_back(size);
    c.weight.push_back(weight);
    c.section.push_back(p.section);
    c.profile.push_back(i);
    o.largest = std::max(o.largest, size);
    ++o.used;
  }
  if (o.used == 0)
    throw Error("no-profiles",
                fmt::format("none of the {} profiles can be used: {} are cut by the border, {} are below the "
                            "smallest visible size",
                            profiles.profiles.size(), o.cut, o.hidden),
                o.cut > 0 ? "set border: all, or use a photograph with particles that the border does not cut"
                          : "lower smallest_visible");

  const bool surface = profiles.view == View::Surface, loose = shows_loose_stones(profiles);
  const double known_fraction = area_fraction > 0 || surface ? area_fraction : profiles.area_fraction;
  o.area = profiles.observed_area;
  const double covered = !surface ? known_fraction : loose ? 1 : profiles.area_fraction;
  o.relative = !(o.area > 0) && !(covered > 0);
  if (!(o.area > 0)) o.area = all / (o.relative ? 1 : covered);
  if (o.relative || (surface && !(known_fraction > 0))) return o;
  // Cut profiles are part of the area fraction, however their number is corrected.
  for (int c = 0; c < classes; ++c)
    o.classes[c].area_fraction =
        known_fraction > 0 ? known_fraction * all_area[c] / all : std::min(1.0, counted_area[c] / o.area);
  return o;
}

}  // namespace terrazzo::unfolding
