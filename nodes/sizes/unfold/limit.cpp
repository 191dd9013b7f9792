#include "nodes/sizes/unfold/limit.h"

#include "graph/diagnostic.h"

namespace terrazzo::unfold {
namespace {

struct Split {
  double first = 0, others = 0;  // N_V of the smallest visible class and of the others
  double first_volume = 0;       // volume fraction of the smallest visible class
};

Split split_at(const unfolding::UnfoldResult& r) {
  Split s;
  for (const auto& f : r.fits) {
    s.first += f.density[0];
    s.others += f.density.sum() - f.density[0];
    s.first_volume += r.model.volume[0] * f.density[0];
  }
  return s;
}

}  // namespace

std::optional<LimitSensitivity> limit_sensitivity(const Profiles& profiles, const KMatrix& k,
                                                  const unfolding::UnfoldOptions& options,
                                                  const unfolding::UnfoldResult& r, const Work& work) {
  if (r.model.visible() < 3) return {};
  const Split whole = split_at(r);
  if (!(whole.first + whole.others > 0) || !(whole.others > 0)) return {};
  unfolding::UnfoldOptions fewer = options;
  fewer.bootstrap = 0;
  fewer.classes = r.model.equal;
  fewer.d_max = r.distribution.d_max;
  fewer.smallest_visible = r.model.profile_edges[1];
  double fraction = 0;
  for (const auto& q : r.observations.classes) fraction += q.area_fraction;
  if (fraction > whole.first_volume) fewer.area_fraction = fraction - whole.first_volume;
  LimitSensitivity out;
  out.share = whole.first / (whole.first + whole.others);
  try {
    const unfolding::UnfoldResult again = unfolding::unfold(profiles, k, fewer, work);
    double others = 0;
    for (const auto& f : again.fits) others += f.density.sum();
    out.change = others / whole.others - 1;
  } catch (const Error& e) {
    const std::string& code = e.diagnostic().code;
    if (code != "no-profiles" && code != "too-few-profiles" && code != "unstable" && code != "singular")
      throw;
    return {};
  }
  return out;
}

}  // namespace terrazzo::unfold
