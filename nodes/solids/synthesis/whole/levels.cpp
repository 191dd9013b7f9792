#include "nodes/solids/synthesis/whole/levels.h"

#include <algorithm>

#include "nodes/data/indices.h"

namespace terrazzo::solids {

std::size_t voxels(const Vec3i& size) { return voxels_in(size); }

Vec3i box_at(const Vec3i& full, int level, int levels) {
  Vec3i s;
  for (int a = 0; a < 3; ++a) s[a] = level_size(full[a], level, levels);
  return s;
}

std::vector<Quantiles> level_values(const std::vector<const ExemplarLevel*>& exemplars, const SolidOptions& s,
                                    int channels) {
  std::vector<Quantiles> out;
  for (int c = 0; c < channels; ++c) {
    std::vector<Quantiles> each;
    for (const auto* e : exemplars) {
      // Texels covered by usable patches.
      std::vector<std::uint8_t> seen(e->usable.size(), 0);
      for (const auto start : e->starts)
        for (int v = 0; v < kPatch; ++v)
          std::fill_n(seen.begin() + start + v * e->width, kPatch, std::uint8_t{1});
      std::vector<float> values;
      for (std::size_t i = 0; i < seen.size(); ++i)
        if (seen[i]) values.push_back(e->texels[4 * i + c]);
      each.push_back(quantiles_of(values));
    }
    std::vector<const Quantiles*> planes;
    for (const int p : s.plane)
      if (p >= 0) planes.push_back(&each[p]);
    out.push_back(mixture(planes));
  }
  return out;
}

std::vector<const ExemplarLevel*> level_of(const std::vector<Pyramid>& pyramids, int level) {
  std::vector<const ExemplarLevel*> out;
  for (const auto& p : pyramids) out.push_back(&p[level]);
  return out;
}

int whole_level(const SolidOptions& s, int levels) {
  if (s.method != SolidMethod::Blockwise) return levels - 1;
  int level = levels - 2;
  while (level > 0 && box_at(s.size, level, levels).cast<double>().prod() > s.blockwise_limits.whole) --level;
  return level;
}

SearchOptions search_settings(const SolidOptions& s) {
  SearchOptions out;
  out.overuse = s.overuse;
  out.copying = s.copying;
  out.seed = s.seed;
  return out;
}

int guided_levels(const SolidOptions& s, int levels) {
  return s.method == SolidMethod::Reference || s.guide <= 0 ? 0 : whole_level(s, levels) + 1;
}

std::vector<int> iterations_of(const SolidOptions& s, int levels) {
  std::vector<int> out;
  for (int l = 0; l < levels; ++l)
    out.push_back(l > whole_level(s, levels) && s.blockwise_iterations > 0
                      ? s.blockwise_iterations
                      : s.iterations[std::min<std::size_t>(l, s.iterations.size() - 1)]);
  return out;
}

int natural_levels(const std::vector<SolidExemplar>& exemplars, const Vec3i& size) {
  int side = 1 << 20;
  for (const auto& e : exemplars) side = std::min({side, e.width, e.height});
  int levels = 1;
  while (level_size(side, 0, levels + 1) >= 24 && level_size(size.minCoeff(), 0, levels + 1) >= kPatch)
    ++levels;
  return levels;
}

}  // namespace terrazzo::solids
