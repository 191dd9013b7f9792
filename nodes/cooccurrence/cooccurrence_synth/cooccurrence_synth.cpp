#include "nodes/cooccurrence/cooccurrence_synth/cooccurrence_synth.h"

#include <fmt/format.h>

#include <algorithm>

#include "nodes/cooccurrence/cooccurrence_synth/patches.h"

namespace terrazzo::cooccurrence_synth {

SynthResult synthesize(const Image& source, const std::vector<std::uint8_t>& mask, const SynthOptions& s,
                       const Work& work) {
  if (source.pixels.empty()) throw Error("no-pixels", "the picture has no pixels");
  const int reach = s.extent << (s.scales - 1);
  const int width = s.width > 0 ? s.width : source.width, height = s.height > 0 ? s.height : source.height;
  const auto larger = [&](const char* what, int w, int h, const char* parameter) {
    if (std::min(w, h) <= reach)
      throw Error("too-small",
                  fmt::format("{} has {} × {} pixels, but offsets reach {} pixels", what, w, h, reach),
                  "make it larger, or reduce extent or scales")
          .parameter(parameter);
  };
  larger("the picture", source.width, source.height, "extent");
  larger("the output", width, height, "size");

  SynthResult r;
  std::vector<Vec3f> pixels;
  for (std::size_t i = 0; i < source.pixels.size(); ++i)
    if (mask.empty() || mask[i]) pixels.push_back(source.pixels[i]);
  if (pixels.empty()) throw Error("no-pixels", "the mask excludes every pixel of the picture");
  r.levels = color_levels(pixels, s.levels, s.space, s.seed, work);
  const int levels = r.levels.count();
  std::vector<LevelField> sections;
  for (int k = 0; k < source.sections; ++k)
    sections.push_back(levels_of(source, k, r.levels, mask, work.quiet()));
  const auto offsets = cooccurrence_offsets(s.extent, s.scales);
  Cooccurrence wanted;  // at full resolution
  const PairTargets targets = [&](int stride, const Vec3i& size) {
    std::vector<PairTarget> out;
    auto here = measure_apart(sections, levels, offsets, stride, work.quiet());
    if (!here) return out;
    for (std::size_t d = 0; d < offsets.size(); ++d) {
      const Vec3i free = s.tileable ? size : Vec3i(size - offsets[d].cwiseAbs());
      out.push_back({offsets[d], scaled_counts(*here, d, static_cast<std::int64_t>(free.x()) * free.y())});
    }
    if (stride == 1) wanted = *std::move(here);
    return out;
  };
  std::vector<const LevelField*> all;
  for (const auto& f : sections) all.push_back(&f);
  DescentOptions descent;
  descent.levels = levels;
  descent.reach = reach;
  descent.sweeps = s.sweeps;
  descent.periodic = s.tileable;
  descent.start = s.start;
  descent.seed = s.seed;
  DescentResult found = descend(all, Vec3i(width, height, 1), targets, descent, work);
  r.noise_error = found.noise_error;
  r.sweeps = std::move(found.sweeps);
  r.field = std::move(found.field);
  r.finished_error = r.sweeps.back().error;
  if (s.finish == Finish::Patches) {
    r.from = patch_sources(source, sections, r.levels, wanted, s.tileable, s.seed, r.field, work.quiet());
    r.finished_error =
        cooccurrence_error(measure_cooccurrence(r.field, levels, offsets, s.tileable, work.quiet()), wanted);
  }
  return r;
}

Image image_of(const LevelField& field, const ColorLevels& levels, double pixel_size) {
  Image out(field.size.x(), field.size.y(), 1, pixel_size);
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    out.pixels[i] = field.at[i] < levels.count() ? levels.color[field.at[i]] : Vec3f::Zero();
  return out;
}

}  // namespace terrazzo::cooccurrence_synth
