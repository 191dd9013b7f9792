#include "nodes/sizes/resample_profiles/resample_profiles.h"

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/sizes/unfolding/bootstrap.h"

namespace terrazzo::resample_profiles {

Profiles resample(const Profiles& profiles, int draw, std::uint64_t seed) {
  if (profiles.profiles.empty())
    throw Error("no-profiles", "there are no profiles to draw from", "use a photograph that shows particles");
  if (draw == 0) return profiles;
  std::vector<int> section;
  for (const Profile& p : profiles.profiles) section.push_back(p.section);
  Random random(seed, 1, draw);
  const std::vector<double> counts = unfolding::draw_counts(section, profiles.sections, random);
  Profiles out = profiles;
  out.profiles.clear();
  double area = 0, drawn = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    // Whole sections have counts that are no whole numbers: a profile appears one time more in that share of
    // cases.
    const double whole = std::floor(counts[i]);
    const int times = static_cast<int>(whole) + (random.uniform() < counts[i] - whole ? 1 : 0);
    for (int k = 0; k < times; ++k) out.profiles.push_back(p);
    area += p.area;
    drawn += times * p.area;
  }
  const double ratio = area > 0 ? drawn / area : 1, binder = 1 - profiles.area_fraction;
  const double covered = profiles.area_fraction * ratio;
  if (profiles.view == View::Surface || !(binder + covered > 0)) return out;
  out.observed_area *= binder + covered;
  out.area_fraction = covered / (binder + covered);
  return out;
}

}  // namespace terrazzo::resample_profiles
