#include "nodes/solids/morph_solids/morph_solids.h"

namespace terrazzo::morph_solids {

patch_fill::FillResult morph(const Torus<Vec3f>& a, const Torus<Vec3f>& b, const Torus<float>& weight,
                             const patch_fill::FillOptions& settings, const Work& work) {
  patch_fill::FillProblem problem{a, b, weight, a, Torus<float>(a.size, 1)};
  for (std::size_t i = 0; i < weight.at.size(); ++i) {
    if (weight.at[i] >= 1) problem.known.at[i] = b.at[i];
    if (weight.at[i] <= 0 || weight.at[i] >= 1) problem.free.at[i] = 0;
  }
  return patch_fill::fill(problem, settings, work);
}

}  // namespace terrazzo::morph_solids
