#include "nodes/textures/texture_set/volume_maps.h"

#include <algorithm>

#include "nodes/bodies/cutting/volume_section.h"
#include "nodes/data/volume.h"

namespace terrazzo::texture_set {
namespace {

// Share of each texel that particles cover; nothing without the grid.
std::vector<float> cover_of(const Volume& volume, const section::SectionLayout& layout, const Work& work) {
  const auto density = volume.find<openvdb::FloatGrid>("density");
  if (!density) return {};
  Volume alone = volume;
  alone.grids = {density};
  std::vector<float> cover;
  for (const Vec3f& c : section::cut_volume(alone, layout, work).image.pixels)
    cover.push_back(std::clamp(c.x(), 0.0f, 1.0f));
  return cover;
}

}  // namespace

TextureMaps paint_maps(const Volume& volume, const section::SectionLayout& layout, double relief,
                       const Roughness& roughness, const Work& work) {
  section::VolumeSection cut = section::cut_volume(volume, layout, work.part(0, 0.4));
  const std::vector<float> cover = cover_of(volume, layout, work.part(0.4, 0.6));
  TextureMaps out;
  out.base_color = std::move(cut.image);
  out.roughness = Image(layout.pixels_x, layout.pixels_y, 1, layout.pixel_size);
  out.id = out.roughness;
  out.height = {layout.pixels_x, layout.pixels_y, layout.width / layout.pixels_x,
                layout.height / layout.pixels_y, std::vector<float>(cover.size())};
  out.height.mm.resize(out.id.pixels.size());
  for (std::size_t i = 0; i < out.id.pixels.size(); ++i) {
    const double share = cover.empty() ? 1.0 : double{cover[i]};
    out.height.mm[i] = static_cast<float>(-(relief > 0 ? relief * (1 - share) : -relief * share));
    out.roughness.pixels[i].setConstant(
        static_cast<float>(share * roughness.particles[0] + (1 - share) * roughness.binder));
    const int profile = cut.labels.ids[i];
    out.id.pixels[i] =
        id_color(profile > 0 ? static_cast<int>(std::get<double>(cut.table.rows[profile - 1][1])) : -1);
  }
  return out;
}

}  // namespace terrazzo::texture_set
