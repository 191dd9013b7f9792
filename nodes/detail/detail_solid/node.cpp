#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/detail.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"
#include "nodes/data/volume.h"
#include "nodes/detail/detail_solid/apply.h"
#include "nodes/detail/detail_solid/broad.h"
#include "nodes/detail/detail_solid/contrast.h"
#include "nodes/detail/detail_solid/ground.h"
#include "nodes/detail/detail_solid/light.h"
#include "nodes/detail/detail_solid/noise.h"
#include "nodes/detail/detail_solid/rim.h"
#include "nodes/detail/detail_solid/skins.h"
#include "nodes/detail/detail_solid/softness.h"
#include "nodes/detail/detail_solid/spectrum.h"
#include "nodes/detail/detail_solid/tiles.h"
#include "nodes/detail/detail_solid/zones.h"
#include "nodes/detail/residual/camera_noise.h"
#include "runtime/context.h"

namespace terrazzo::detail_solid {
namespace {

// Fills in the tiles of all phases.
void make_tiles(Context& c, const Phases& phases, const std::vector<Vec3f>& broad, const Labels& labels,
                Detail& detail, std::vector<PartialPicture>& exemplars, const Work& work) {
  const auto count = phases.pixels.size();
  for (std::size_t p = 0; p < count; ++p) {
    const Work part = work.part(double(p) / double(count), double(p + 1) / double(count));
    const std::uint64_t seed = c.seed() * 64 + p;
    exemplars.push_back(phase_exemplar(phases, p, 2 * detail.size, seed, part.part(0, 0.05)));
    auto values = phase_tile(exemplars.back(), detail.size, seed, part.part(0.05, 0.9));
    match_phase(values, phases, phases.offset, p, work.quiet());
    match_spectrum(values, detail.size, phases, p, work.quiet());
    match_phase(values, phases, phases.offset, p, work.quiet());
    detail.phases[p].broad =
        broad_field(fit_broad(broad, phases, labels, p, seed), detail.size, seed, part.part(0.9, 1));
    detail.phases[p].tile = std::move(values);
  }
}

// Two rows, about middle gray: the exemplars, and below each the middle slices of its tile, repeated 2 × 2.
Image picture_of(const std::vector<PartialPicture>& exemplars, const Detail& detail) {
  const int size = detail.size, side = 2 * size;
  Image out(side * count_of(exemplars), 2 * side, 1, detail.pixel_size,
            srgb_to_linear(Vec3f::Constant(0.5f)));
  const auto shown = [](const Vec3f& v) {
    return srgb_to_linear(Vec3f((v.array() + 0.5f).cwiseMax(0.0f).cwiseMin(1.0f)));
  };
  for (std::size_t n = 0; n < exemplars.size(); ++n) {
    const PartialPicture& e = exemplars[n];
    const int left = side * static_cast<int>(n);
    for (int y = 0; y < e.height; ++y)
      for (int x = 0; x < e.width; ++x) out.at(left + x, y) = shown(e.value[pixel_at(x, y, e.width)]);
    const std::size_t first = static_cast<std::size_t>(size / 2) * size * size;
    const auto slice = [&](std::size_t i) {
      return Vec3f(detail.phases[n].tile[first + i] + detail.phases[n].broad[first + i]);
    };
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        out.at(left + x, 2 * side - 1 - y) =
            shown(slice(static_cast<std::size_t>(y % size) * size + x % size));
  }
  return out;
}

// What only a photograph of a surface shows.
void keep_surface(const Context& c, const Image& image, const Labels& labels, const Profiles& profiles,
                  Detail& detail) {
  Outsides outsides = find_skins(image, labels, profiles, c.seed(), c.work().quiet());
  detail.skins = std::move(outsides.skins);
  detail.relief = outsides.relief;
  const Labels* mask = c.optional<Labels>("mask");
  detail.ground = find_ground(image, labels, mask, profiles, c.seed(), c.work().quiet());
  detail.tones = find_tones(image, mask, profiles);
}

// In the unit of offsets, which those of particles have divided by their scale. The binder may have zones, so
// that its color alone does not tell its noise.
std::vector<float> noise_of_phases(const Detail::Noise& noise, const Phases& phases) {
  std::vector<float> out{*std::max_element(noise.gray.begin(), noise.gray.end())};
  for (const Vec3f& color : phases.group_color) {
    const Vec3f encoded = linear_to_srgb(color);
    out.push_back(residual::deviation_at(noise.gray, encoded.mean()) / Detail::particle_scale(encoded));
  }
  return out;
}

// Measures the camera's noise, if there is any, and gives `clean` the photograph without it. Not of surfaces,
// whose skins and soil are shown as they were photographed.
void take_out_noise(Context& c, const Image& photograph, const Labels& labels, const Labels* mask,
                    const Profiles* profiles, Detail& detail, Image& clean) {
  if (c.boolean("noise") && !(profiles && profiles->view == View::Surface)) {
    clean = photograph;
    detail.noise = split_noise(clean, labels, mask, detail.softness, detail.gray, c.work().part(0, 0.02));
    if (detail.noise.gray.empty()) clean = {};
  }
  double sum = 0;
  for (const float d : detail.noise.gray) sum += d / detail.noise.gray.size();
  c.metric("noise", sum);
}

void compute(Context& c) {
  const auto& photograph = c.input<Image>("image");
  const auto& labels = c.input<Labels>("labels");
  check_photograph(photograph, labels);
  const Profiles* profiles = c.optional<Profiles>("profiles");
  const Labels* mask = c.optional<Labels>("mask");
  if (mask)
    require_equal_size(*mask, "the mask has", photograph, "the image has",
                       "use the mask of the same photograph");
  Detail detail;
  detail.pixel_size = photograph.pixel_size;
  detail.size = c.integer("size");
  detail.gray = std::all_of(photograph.pixels.begin(), photograph.pixels.end(),
                            [](const Vec3f& v) { return v.maxCoeff() - v.minCoeff() < 1e-6f; });
  detail.softness = outline_softness(photograph, labels);
  c.metric("softness", detail.softness);
  Image clean;
  take_out_noise(c, photograph, labels, mask, profiles, detail, clean);
  const Image& image = clean.pixels.empty() ? photograph : clean;
  PhaseOptions choice;
  choice.edge = c.integer("edge");
  choice.softness = detail.softness;
  if (profiles && profiles->view == View::Section && profiles->binder_color.allFinite())
    choice.binder = profiles->binder_color;
  choice.specks = c.number("specks");
  choice.groups = c.integer("groups");
  choice.mask = mask;
  choice.seed = c.seed();
  Phases phases = find_phases(image, labels, choice, c.work().part(0.02, 0.03));
  if (!detail.noise.gray.empty()) phases.noise = noise_of_phases(detail.noise, phases);
  c.metric("groups", phases.group_color.size());
  c.metric("outliers", phases.outliers);
  detail.phases.resize(phases.pixels.size());
  split_zones(phases, labels, detail, choice.seed, c.work().quiet());
  c.metric("zones", detail.zones.level.empty() ? 1 : 2);
  split_rims(phases, labels, detail);
  if (c.boolean("light")) split_light(phases, labels, detail);
  const std::vector<double> slopes = split_slopes(phases, labels);
  for (std::size_t g = 0; g < slopes.size(); ++g) {
    detail.phases[g + 1].color = phases.group_color[g];
    detail.phases[g + 1].slope = slopes[g];
  }
  split_gains(phases, labels, detail);
  split_zone_contrasts(phases, detail);
  split_contrasts(phases, image, labels, detail, c.work());
  keep_deep_pixels(phases, labels);
  const std::vector<Vec3f> broad = split_broad(phases, labels, c.work().part(0.03, 0.04));
  if (profiles) keep_surface(c, image, labels, *profiles, detail);
  c.metric("skins", detail.skins.size());
  c.metric("relief", detail.relief.strength);
  const bool apply = c.has("volume");
  std::vector<PartialPicture> exemplars;
  make_tiles(c, phases, broad, labels, detail, exemplars, c.work().part(0.04, apply ? 0.9 : 1));
  c.output("exemplars", picture_of(exemplars, detail));
  if (apply)
    c.output("volume", add_detail(*c.optional<Volume>("volume"), detail, c.work().part(0.9, 1)));
  else
    c.output("volume", Volume());
  c.output("detail", std::move(detail));
}

}  // namespace
}  // namespace terrazzo::detail_solid

namespace terrazzo {

NodeType detail_solid_node() {
  using namespace detail_solid;
  return NodeType("DetailSolid", 22)
      .doc_(
          "Synthesizes the fine detail of a photograph's binder and particles separately, each from its own "
          "pixels, and adds it to a solid")
      .source_(
          "Kopf et al. 2007 and Laursen, Ersbøll, Bærentzen 2011 for the tiles; Wexler, Shechtman, Irani "
          "2007 for what particles and binder hide from each other; Yu, Sapiro 2011 for noise; Hildebrand, "
          "Rüegsegger 1997 for the width of the binder")
      .input("image", "Image", "Photograph with one or more sections")
      .input("labels", "Labels", "Profiles of image")
      .optional_input("mask", {"Labels"},
                      "Not 0: pixels that are neither particle nor binder and teach nothing, such as output "
                      "unobserved of Segment. 1: not even the material")
      .optional_input(
          "profiles", {"Profiles"},
          "Profiles of the labels, whose binder color the binder's offsets refer to. If they show a surface, "
          "the outside of each stone is kept for View")
      .optional_input("volume", {"Volume"},
                      "Solid without detail, from Voxelize: its grids Cd, id and density")
      .output("volume", "Volume", "The solid with detail in its grid Cd. Empty without a volume")
      .output(
          "detail", "Detail",
          "Tiles of the binder's and the particles' detail at the photograph's scale, for Section, Voxelize "
          "and RenderSolid")
      .output("exemplars", "Image",
              "What each tile was made from, in the phases' order, and below it a slice of the tile: offsets "
              "about middle gray")
      .parameter(Parameter::integer("size", 64)
                     .range(16, 256)
                     .unit_("voxels")
                     .doc_("Edge length of the tiles. Particles and parts of the binder each show a tile in "
                           "their own place, so it need not be as large as the solid."))
      .parameter(Parameter::integer("groups", 2)
                     .range(1, 16)
                     .doc_("Largest number of groups of particles, by color, that have a tile of their own"))
      .parameter(Parameter::integer("edge", 1).range(0, 32).unit_("pixels").doc_(
          "Width of the band on each side of outlines whose pixels are not used"))
      .parameter(
          Parameter::number("specks", 6)
              .range(0, 1e6)
              .doc_("Limit in robust standard deviations from the binder's median. Binder pixels beyond it "
                    "are particles missed by the labels and are not used. 0 uses them."))
      .parameter(Parameter::boolean("light", true)
                     .doc_("Measure how the photograph's light falls on profiles and beside them, such as "
                           "lighter upper sides and shadows below. Section adds it to pictures; volumes and "
                           "rendered solids do not contain it."))
      .parameter(Parameter::boolean("noise", true)
                     .doc_("Measure the camera's noise, which is alike in all places, apart from the grain "
                           "of the material. Pictures of Section, View and Repaint show it; volumes and "
                           "rendered solids do not contain it. Surfaces keep theirs."))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
