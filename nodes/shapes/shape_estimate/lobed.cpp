#include "nodes/shapes/shape_estimate/lobed.h"

#include <algorithm>
#include <cmath>

#include "nodes/shapes/shape_estimate/feature_match.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/shapes/shape_estimate/size_selection.h"

namespace terrazzo::shape_estimate {
namespace {

constexpr std::size_t kFewestLobed = 4;
constexpr double kRarestLobed = 0.1;
constexpr int kLobedGuesses = 64;
constexpr std::size_t kLobedPlanes = 192;

// Whether lobed profiles are larger than others, beyond chance: the rank-sum test (Mann, Whitney 1947).
// `all`: by decreasing area.
bool are_larger(const std::vector<Outline>& all, const std::vector<char>& lobed) {
  constexpr double kOneSided = 1.645;  // at 5 %
  double others = 0, smaller = 0, count = 0;
  for (std::size_t i = all.size(); i-- > 0;) {
    if (lobed[i]) {
      ++count;
      smaller += others;
    } else {
      ++others;
    }
  }
  const double pairs = count * others;
  return smaller - pairs / 2 > kOneSided * std::sqrt(pairs * (count + others + 1) / 12);
}

}  // namespace

std::optional<Forms> forms_of(const std::vector<Outline>& all, const ProfileMeasuring& how) {
  Forms out;
  std::vector<double> areas;  // of lobed ones
  for (const Outline& o : all) {
    out.lobed.push_back(convexity_of(o, how) < kLobed);
    if (out.lobed.back()) areas.push_back(o.area);
  }
  if (areas.size() < kFewestLobed ||
      static_cast<double>(areas.size()) < kRarestLobed * static_cast<double>(all.size()) ||
      !are_larger(all, out.lobed))
    return {};
  std::sort(areas.begin(), areas.end());
  const double large = areas[areas.size() / 4];
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].area >= large) out.large.push_back(all[i]);
    if (out.lobed[i] || all[i].area >= large) out.not_compact.push_back(all[i].id);
  }
  std::sort(out.not_compact.begin(), out.not_compact.end());
  return out;
}

std::vector<Mesh> lobed_bodies(const std::vector<Outline>& large, const ProfileMeasuring& how, int count,
                               std::uint64_t seed, const Work& work) {
  FeatureSample observed;
  std::vector<double> sizes;
  for (const Outline& o : large) {
    observed.features.push_back(profile_features(o, how));
    observed.root_area.push_back(std::sqrt(o.area));
    observed.weight.push_back(1);
    sizes.push_back(std::sqrt(o.area));
  }
  const FeatureTarget target(observed, false, seed);
  std::vector<Mesh> bodies(kLobedGuesses);
  std::vector<std::vector<CutProfile>> sections(kLobedGuesses);
  work.part(0, 0.5).parallel(kLobedGuesses, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      bodies[i] = lobed_body(seed, static_cast<int>(i));
      sections[i] = cut_sections(bodies[i], kLobedPlanes);
    }
  });
  const SizeSelection selection(sizes, sections);
  std::vector<std::pair<double, std::size_t>> order(kLobedGuesses);
  work.part(0.5, 1).parallel(kLobedGuesses, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      selection.apply(sections[i]);
      order[i] = {target.distance(measured(sections[i], how)), i};
    }
  });
  std::sort(order.begin(), order.end());
  std::vector<Mesh> out;
  for (int k = 0; k < std::min(count, kLobedGuesses); ++k) out.push_back(std::move(bodies[order[k].second]));
  return out;
}

}  // namespace terrazzo::shape_estimate
