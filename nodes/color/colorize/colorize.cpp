#include "nodes/color/colorize/colorize.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "nodes/color/colorize/colors_of_sizes.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/kmeans.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
#include "runtime/random.h"

namespace terrazzo::colorize {
namespace {

constexpr double kLeastPart = 0.4;  // diameter of a fragment, in that of the particle

enum Stream : std::uint64_t { kProfile = 0xc0, kClass = 0xc1, kFragment = 0xc2 };

// Weighted random choice among items from one uniform number.
class Draw {
 public:
  void add(std::size_t item, double weight) {
    if (weight <= 0) return;
    items_.push_back(item);
    sums_.push_back((sums_.empty() ? 0.0 : sums_.back()) + weight);
  }
  bool empty() const { return items_.empty(); }
  std::size_t pick(double u) const {
    const auto at = std::upper_bound(sums_.begin(), sums_.end(), u * sums_.back());
    return items_[std::min<std::size_t>(at - sums_.begin(), items_.size() - 1)];
  }

 private:
  std::vector<std::size_t> items_;
  std::vector<double> sums_;
};

struct Source {
  std::vector<Vec3f> color;
  std::vector<double> weight, size;  // size: √(4A/π), mm
  std::vector<int> cls;
  std::size_t count() const { return color.size(); }
};

// Which stones of a surface have their color from lying deep: those that others hide by half, and, between
// loose stones, those as dark as the gaps, unless they are larger than most. A view from above gives them
// their shadow.
class Shadows {
 public:
  explicit Shadows(const Profiles& all) {
    if (all.view != View::Surface) return;
    std::vector<double> whole;
    for (const Profile& p : all.profiles)
      if (!hidden(p)) whole.push_back(p.whole);
    if (whole.empty()) return;
    surface_ = true;
    if (!shows_loose_stones(all)) return;
    larger_ = median(std::move(whole));
    dark_ = luminance_of(all.binder_color);
  }

  bool hold(const Profile& p) const {
    return surface_ && (hidden(p) || (p.whole < larger_ && luminance_of(p.color) <= dark_));
  }

 private:
  static bool hidden(const Profile& p) { return p.area < 0.5 * p.whole; }

  bool surface_ = false;
  double larger_ = 0;  // mm²
  float dark_ = 0;
};

// Classes without any other color keep those of their stones in the shadow.
Source source_of(const Profiles& profiles, bool weightless, const Shadows& shadows) {
  std::set<int> lit;
  for (const Profile& p : profiles.profiles)
    if ((weightless || p.weight > 0) && !shadows.hold(p)) lit.insert(p.cls);
  Source s;
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    if (!p.color.allFinite() || !std::isfinite(p.weight) || p.weight < 0 || !std::isfinite(p.area) ||
        p.area <= 0)
      throw Error("bad-profile", "profile " + std::to_string(i + 1) + " has no valid color, weight or area",
                  "check the photograph for NaN and the segmentation for empty profiles");
    const double w = weightless ? 1 : p.weight;
    if (w == 0 || (shadows.hold(p) && lit.contains(p.cls))) continue;
    s.color.push_back(p.color);
    s.weight.push_back(w);
    s.cls.push_back(p.cls);
    const double area = profiles.view == View::Surface ? std::max(p.area, p.whole) : p.area;
    s.size.push_back(std::sqrt(4 * area / std::numbers::pi));
  }
  return s;
}

Source usable(const Profiles& profiles, ColorReport& report) {
  if (profiles.profiles.empty())
    throw Error("no-profiles", "there are no profiles to draw colors from", "check the segmentation");
  if (!profiles.binder_color.allFinite())
    throw Error("bad-profile", "the binder's color contains NaN or infinity");
  report.weightless = std::none_of(profiles.profiles.begin(), profiles.profiles.end(),
                                   [](const Profile& p) { return p.weight > 0; });
  report.colorless = std::all_of(profiles.profiles.begin(), profiles.profiles.end(),
                                 [](const Profile& p) { return p.color.isZero(0); });
  Source s = source_of(profiles, report.weightless, Shadows(profiles));
  report.profiles_used = s.count();
  return s;
}

// The profiles of a class (−1: all), and which particles of that class show them.
struct Group {
  std::vector<std::size_t> members, by_size;
  std::optional<ColorsOfSizes> colors;

  Group(const Source& s, int cls) {
    for (std::size_t i = 0; i < s.count(); ++i)
      if (cls < 0 || s.cls[i] == cls) members.push_back(i);
    by_size = members;
    std::stable_sort(by_size.begin(), by_size.end(), [&](auto a, auto b) { return s.size[a] < s.size[b]; });
  }
  void estimate(const Source& s, const Particles& particles, int cls, std::uint64_t seed, const Work& work) {
    std::vector<ColoredProfile> profiles;
    for (const std::size_t i : members) profiles.push_back({s.size[i], s.weight[i], s.color[i]});
    std::vector<double> sizes;
    for (std::size_t i = 0; i < particles.count(); ++i)
      if (!particles.is_void(i) && (cls < 0 || particles.cls[i] == cls)) sizes.push_back(particles.size[i]);
    if (!sizes.empty()) colors.emplace(profiles, sizes, seed, work);
  }
  // The profiles that a particle of this size may show.
  Draw draw(const Source& s, double size) const {
    Draw draw;
    for (std::size_t k = 0; k < members.size(); ++k) draw.add(members[k], colors->weight(k, size));
    if (draw.empty()) {
      // No profile is between the particle's size and 0.95 of it, or all are larger: use the nearest below,
      // or else the smallest.
      const auto above = std::upper_bound(by_size.begin(), by_size.end(), size,
                                          [&](double v, std::size_t i) { return v < s.size[i]; });
      const std::size_t n = std::max<std::size_t>(1, by_size.size() / 10);
      const std::size_t end = std::max<std::size_t>(above - by_size.begin(), n);
      for (std::size_t i = end - n; i < end; ++i) draw.add(by_size[i], s.weight[by_size[i]]);
    }
    return draw;
  }
};

// Particles whose outlines are unknown have other colors than those that were found: most lie in the shadow.
// So as many particles as the fragments' share of the area take the color of a fragment, unless it is far
// smaller than they are.
void color_by_fragments(Particles& particles, const Profiles& profiles, std::uint64_t seed,
                        ColorReport& report, const Work& work) {
  Draw draw;
  double found = 0, hidden = 0;
  for (const Profile& p : profiles.profiles) found += p.area;
  for (std::size_t k = 0; k < profiles.fragments.size(); ++k) {
    const Fragment& f = profiles.fragments[k];
    if (!f.color.allFinite() || !std::isfinite(f.area) || f.area < 0)
      throw Error("bad-profile", "fragment " + std::to_string(k + 1) + " has no valid color or area",
                  "check the photograph for NaN");
    if (profiles.view != View::Surface) draw.add(k, f.area);
    hidden += f.area;
  }
  if (draw.empty()) return;
  report.hidden = hidden / (found + hidden);
  work.parallel(particles.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, kFragment, i);
      if (random.uniform() >= report.hidden || particles.is_void(i)) continue;
      const Fragment& f = profiles.fragments[draw.pick(random.uniform())];
      if (std::sqrt(4 * f.area / std::numbers::pi) >= kLeastPart * particles.size[i])
        particles.color[i] = f.color;
    }
  });
}

// Throws if no complete profile has the class of a particle.
void require_class(int c, bool known) {
  if (known) return;
  throw Error("no-class", "no complete profile has the class " + std::to_string(c) + " of a particle",
              "set mode: random, or use particles and profiles of the same segmentation");
}

// Gives each particle the color of the profile pick(particle, uniform number).
template <class Pick>
void color_by_profiles(Particles& particles, const Source& source, std::uint64_t seed, const Work& work,
                       Pick&& pick) {
  work.parallel(particles.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!particles.is_void(i))
        particles.color[i] = source.color[pick(i, Random(seed, kProfile, i).uniform())];
  });
}

// `own`: among the profiles of the particle's class.
void color_by_size(Particles& particles, const Source& source, bool own, std::uint64_t seed,
                   const Work& work) {
  std::map<int, Group> groups;  // of each class of particles, or of −1
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const int c = own ? particles.cls[i] : -1;
    if (particles.is_void(i) || groups.contains(c)) continue;
    require_class(c, !groups.emplace(c, Group(source, c)).first->second.members.empty());
  }
  for (auto& [c, group] : groups) group.estimate(source, particles, c, seed, work);
  color_by_profiles(particles, source, seed, work, [&](std::size_t i, double u) {
    return groups.at(own ? particles.cls[i] : -1).draw(source, particles.size[i]).pick(u);
  });
}

// Draws classes of particles that have none. If profiles have none either, clusters of their colors become
// classes.
void draw_classes(Particles& particles, Source& source, int classes, const ColorOptions& choice,
                  ColorReport& report, const Work& work) {
  Group all(source, -1);
  if (classes <= 1) {
    std::vector<Vec3> lab;
    for (const auto& c : source.color) lab.push_back(linear_to_oklab(c).cast<double>());
    ColorClusters found = choice.clusters > 0 ? kmeans(lab, source.weight, choice.clusters, choice.seed, work)
                                              : kmeans_auto(lab, source.weight, 8, choice.seed, 0.5, work);
    report.clusters = found.k;
    report.silhouette = found.silhouette;
    source.cls = std::move(found.of);
  }
  all.estimate(source, particles, -1, choice.seed, work);
  work.parallel(particles.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!particles.is_void(i))
        particles.cls[i] =
            source.cls[all.draw(source, particles.size[i]).pick(Random(choice.seed, kClass, i).uniform())];
  });
}

void color_by_class(Particles& particles, const Source& source, std::uint64_t seed, const Work& work) {
  std::vector<Draw> draws;
  for (std::size_t i = 0; i < source.count(); ++i) {
    if (source.cls[i] < 0)
      throw Error("bad-profile", "a profile has the invalid class " + std::to_string(source.cls[i]));
    if (draws.size() <= static_cast<std::size_t>(source.cls[i])) draws.resize(source.cls[i] + 1);
    draws[source.cls[i]].add(i, source.weight[i]);
  }
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (const int c = particles.cls[i]; !particles.is_void(i))
      require_class(c, c >= 0 && c < count_of(draws) && !draws[c].empty());
  color_by_profiles(particles, source, seed, work,
                    [&](std::size_t i, double u) { return draws[particles.cls[i]].pick(u); });
}

}  // namespace

ColorReport colorize(Particles& particles, const Profiles& profiles, const ColorOptions& choice,
                     const Work& work) {
  ColorReport report;
  Source source = usable(profiles, report);
  particles.binder_color = profiles.binder_color;
  const std::size_t n = particles.count();
  for (std::size_t i = 0; i < n; ++i)
    if (!(particles.size[i] > 0) || !std::isfinite(particles.size[i]))
      throw Error("bad-particle", "particle " + std::to_string(i) + " has no size");
  bool classed = false;
  for (std::size_t i = 0; i < n; ++i) classed = classed || (particles.cls[i] != 0 && !particles.is_void(i));

  if (choice.mode == ColorMode::Random) {
    Draw draw;
    for (std::size_t i = 0; i < source.count(); ++i) draw.add(i, source.weight[i]);
    color_by_profiles(particles, source, choice.seed, work,
                      [&](std::size_t, double u) { return draw.pick(u); });
  } else if (choice.mode == ColorMode::BySize) {
    color_by_size(particles, source, classed && profiles.classes > 1, choice.seed, work);
  } else {
    if (!classed) draw_classes(particles, source, profiles.classes, choice, report, work);
    color_by_class(particles, source, choice.seed, work);
    return report;
  }
  color_by_fragments(particles, profiles, choice.seed, report, work);
  return report;
}

}  // namespace terrazzo::colorize
