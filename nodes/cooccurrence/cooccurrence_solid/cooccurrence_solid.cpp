#include "nodes/cooccurrence/cooccurrence_solid/cooccurrence_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace terrazzo::cooccurrence_solid {

SolidFieldResult synthesize_solid(const std::array<const Image*, 3>& pictures, const SolidFieldOptions& s,
                                  const Work& work) {
  const int reach = s.extent << (s.scales - 1);
  if (s.size.minCoeff() <= reach)
    throw Error("too-small",
                fmt::format("the solid has {} × {} × {} voxels, but offsets reach {} voxels", s.size.x(),
                            s.size.y(), s.size.z(), reach),
                "make the solid larger, or reduce extent or scales")
        .parameter("size");
  const std::set<const Image*> different(pictures.begin(), pictures.end());
  std::vector<Vec3f> pixels;
  for (std::size_t a = 0; a < 3; ++a) {
    const Image& p = *pictures[a];
    if (p.pixels.empty()) throw Error("no-pixels", "a picture has no pixels");
    if (std::min(p.width, p.height) <= reach)
      throw Error(
          "too-small",
          fmt::format("a picture has {} × {} pixels, but offsets reach {} pixels", p.width, p.height, reach),
          "use a larger picture, or reduce extent or scales")
          .parameter("extent");
    if (different.size() > 1 || a == 0) pixels.insert(pixels.end(), p.pixels.begin(), p.pixels.end());
  }
  SolidFieldResult r;
  r.levels = color_levels(pixels, s.levels, s.space, s.seed, work);
  const int levels = r.levels.count();

  const auto flat = cooccurrence_offsets(s.extent, s.scales);
  std::array<std::vector<LevelField>, 3> sections;
  std::vector<const LevelField*> all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Image& p = *pictures[axis];
    for (int k = 0; k < p.sections; ++k)
      sections[axis].push_back(levels_of(p, k, r.levels, {}, work.quiet()));
    for (const auto& f : sections[axis]) all.push_back(&f);
  }
  std::array<Cooccurrence, 3> wanted;  // at full resolution
  const PairTargets targets = [&](int stride, const Vec3i& size) {
    std::vector<PairTarget> out;
    const std::int64_t voxels = static_cast<std::int64_t>(size.x()) * size.y() * size.z();
    for (int axis = 0; axis < 3; ++axis) {
      auto own = measure_apart(sections[axis], levels, flat, stride, work.quiet());
      if (!own) return std::vector<PairTarget>();
      for (std::size_t d = 0; d < flat.size(); ++d)
        out.push_back({offset_across(axis, flat[d]), scaled_counts(*own, d, voxels)});
      if (stride == 1) wanted[axis] = *std::move(own);
    }
    return out;
  };
  DescentOptions descent;
  descent.levels = levels;
  descent.reach = reach;
  descent.sweeps = s.sweeps;
  descent.start = s.start;
  descent.seed = s.seed;
  DescentResult found = descend(all, s.size, targets, descent, work);
  r.noise_error = found.noise_error;
  r.sweeps = std::move(found.sweeps);
  r.field = std::move(found.field);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3i> offsets;
    for (const auto& o : flat) offsets.push_back(offset_across(axis, o));
    Cooccurrence have = measure_cooccurrence(r.field, levels, offsets, true, work.quiet());
    r.axis_error[axis] = cooccurrence_error(have, wanted[axis]);
  }
  return r;
}

}  // namespace terrazzo::cooccurrence_solid
