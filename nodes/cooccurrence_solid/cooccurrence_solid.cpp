#include "nodes/cooccurrence_solid/cooccurrence_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "nodes/common/level_descent.h"
#include "runtime/random.h"

namespace terrazzo::cooccurrence_solid {

SolidFieldResult synthesize_solid(const std::array<const Image*, 3>& pictures, const SolidFieldSettings& s,
                                  const Work& work) {
  const int reach = s.extent << (s.scales - 1);
  if (s.size.minCoeff() <= reach)
    throw Error("too-small",
                fmt::format("a solid of {} × {} × {} voxels, the offsets reach {}", s.size.x(), s.size.y(),
                            s.size.z(), reach),
                "make it larger, or extent or scales smaller")
        .parameter("size");
  const std::set<const Image*> different(pictures.begin(), pictures.end());
  std::vector<Vec3f> pixels;
  for (std::size_t a = 0; a < 3; ++a) {
    const Image& p = *pictures[a];
    if (p.pixels.empty()) throw Error("no-pixels", "a picture has no pixels");
    if (std::min(p.width, p.height) <= reach)
      throw Error("too-small",
                  fmt::format("a picture has {} × {} pixels, the offsets reach {}", p.width, p.height, reach),
                  "make it larger, or extent or scales smaller")
          .parameter("extent");
    if (different.size() > 1 || a == 0) pixels.insert(pixels.end(), p.pixels.begin(), p.pixels.end());
  }
  SolidFieldResult r;
  r.levels = color_levels(pixels, s.levels, s.space, s.seed, work);
  const int levels = r.levels.count();

  const auto flat = cooccurrence_offsets(s.extent, s.scales);
  const std::int64_t voxels = static_cast<std::int64_t>(s.size.x()) * s.size.y() * s.size.z();
  std::vector<PairTarget> targets;
  std::vector<LevelField> sections;
  std::vector<Cooccurrence> wanted;
  for (int axis = 0; axis < 3; ++axis) {
    const Image& p = *pictures[static_cast<std::size_t>(axis)];
    std::vector<LevelField> own;
    for (int k = 0; k < p.sections; ++k) own.push_back(levels_of(p, k, r.levels, {}, work.quiet()));
    wanted.push_back(measure_cooccurrence(own, levels, flat, work.quiet()));
    for (std::size_t d = 0; d < flat.size(); ++d)
      targets.push_back({offset_across(axis, flat[d]), scaled_counts(wanted.back(), d, voxels)});
    for (auto& f : own) sections.push_back(std::move(f));
  }
  std::vector<const LevelField*> all;
  for (const auto& f : sections) all.push_back(&f);
  LevelDescent descent(level_noise(all, levels, s.size, s.seed), levels, true, targets);
  sections.clear();
  r.error.push_back(descent.error());
  for (int k = 0; k < s.sweeps; ++k) {
    r.changed.push_back(
        descent.sweep(mix64(s.seed) + static_cast<std::uint64_t>(k),
                      work.part(static_cast<double>(k) / s.sweeps, static_cast<double>(k + 1) / s.sweeps)));
    r.error.push_back(descent.error());
    if (r.changed.back() == 0) break;
  }
  r.field = descent.field();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3i> offsets;
    for (const auto& o : flat) offsets.push_back(offset_across(axis, o));
    Cooccurrence have = measure_cooccurrence(r.field, levels, offsets, true, work.quiet());
    r.axis_error[static_cast<std::size_t>(axis)] =
        cooccurrence_error(have, wanted[static_cast<std::size_t>(axis)]);
  }
  return r;
}

}  // namespace terrazzo::cooccurrence_solid
