#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/cutting/cut.h"
#include "nodes/bodies/cutting/volume_section.h"
#include "nodes/data/detail.h"
#include "nodes/data/volume.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/textures/relief/lit_picture.h"
#include "nodes/textures/texture_set/volume_maps.h"
#include "runtime/context.h"

namespace terrazzo::texture_set {
namespace {

// What a finish does if the parameters leave it open.
struct Defaults {
  double relief;             // relative to the mean size of the particles
  double particles, binder;  // roughness
};
Defaults defaults_of(FinishKind kind) {
  switch (kind) {
    case FinishKind::Polished:
      return {0, Roughness::kPolishedParticle, Roughness::kPolishedBinder};
    case FinishKind::Honed:
      return {0.01, 0.35, 0.55};
    case FinishKind::Weathered:
      return {0.12, Roughness::kNaturalParticle, Roughness::kNaturalBinder};
    default:
      return {0.1, Roughness::kNaturalParticle, Roughness::kNaturalBinder};
  }
}

Roughness roughness_of(const Context& c, FinishKind kind) {
  const Defaults defaults = defaults_of(kind);
  Roughness roughness;
  roughness.particles = {defaults.particles};
  if (c.keyword("roughness").empty()) roughness.particles = c.numbers("roughness");
  roughness.binder = c.optional_number("binder_roughness").value_or(defaults.binder);
  return roughness;
}

// Refuses sizes whose maps do not fit into memory, before anything is computed.
section::SectionLayout layout_of(const Context& c, const Vec3& box) {
  constexpr double kBytes = 150;  // of each texel: six maps of three floats, and what makes and stores them
  section::SectionOptions choice;
  choice.axis = c.text("axis");
  const int axis = choice.axis[0] - 'x';
  if (const auto position = c.optional_number("position")) {
    if (*position > box[axis])
      throw Error("bad-offset",
                  fmt::format("the plane at {} = {:g} mm misses the box, which ends at {:g} mm", choice.axis,
                              *position, box[axis]),
                  fmt::format("position must be within 0 … {:g} mm", box[axis]))
          .parameter("position");
    choice.offsets = {*position};
  }
  const double longer = std::max(box[(axis + 1) % 3], box[(axis + 2) % 3]);
  const double shorter = std::min(box[(axis + 1) % 3], box[(axis + 2) % 3]);
  const double edge = c.integer("resolution"), bytes = edge * edge * (shorter / longer) * kBytes;
  if (bytes > static_cast<double>(c.memory()))
    throw Error(
        "too-large",
        fmt::format(
            "maps of {:.0f} × {:.0f} pixels need about {:.1f} GB of memory, but only {:.1f} GB are available",
            edge, edge * shorter / longer, bytes / 1e9, static_cast<double>(c.memory()) / 1e9),
        "lower resolution, or raise --memory if the machine has more memory")
        .parameter("resolution");
  choice.pixel_size = longer / edge;
  return section::choose_planes(choice, box, true, 1);
}

double mean_size(const Particles& particles) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i) && particles.size[i] > 0) {
      sum += particles.size[i];
      ++count;
    }
  return count ? sum / static_cast<double>(count) : particles.box.minCoeff() / 10;
}

// The relief, and the radius of edges.
struct Wear {
  double relief = 0, rounding = 0;  // mm
};
Wear wear_of(const Context& c, FinishKind kind, double relief, const Vec3& box) {
  if (kind == FinishKind::Polished || kind == FinishKind::Loose) return {};
  relief = c.optional_number("relief").value_or(relief);
  const double period = box[c.text("axis")[0] - 'x'];
  if (!(std::abs(relief) <= period / 2))
    throw Error("bad-value",
                fmt::format("relief is {:g} mm, but the solid repeats after {:g} mm along {}", relief, period,
                            c.text("axis")),
                fmt::format("relief must be at most {:g} mm", period / 2))
        .parameter("relief");
  if (kind == FinishKind::Broken) return {relief, 0};
  const double rounding = c.optional_number("rounding").value_or(std::abs(relief) / 2);
  if (!(rounding <= std::abs(relief)))
    throw Error("bad-value",
                fmt::format("rounding is {:g} mm, more than the relief of {:g} mm", rounding, relief),
                "lower rounding, or raise relief")
        .parameter("rounding");
  return {relief, rounding};
}

TextureMaps maps_of_particles(Context& c, FinishKind kind) {
  const auto& particles = c.input<Particles>("particles");
  const auto& shapes = c.input<Shapes>("shapes");
  section::check_particles(particles, shapes);
  const section::SectionLayout layout = layout_of(c, particles.box);
  const double grain = mean_size(particles);
  const Wear wear = wear_of(c, kind, defaults_of(kind).relief * grain, particles.box);
  std::optional<residual::ResidualField> field;
  double softness = 0;
  if (const Detail* detail = c.optional<Detail>("detail")) {
    textures::check_softness(*detail, layout.pixel_size, "resolution", "lower resolution");
    field.emplace(textures::unlit(*detail), particles, layout.pixel_size, residual::Keep::Power,
                  c.work().part(0, 0.1));
    softness = detail->softness * detail->pixel_size;
  }
  const FinishedSurface surface(particles, shapes, layout, {kind, wear.relief, grain, c.seed()}, c.work());
  TextureMaps maps = paint_maps(surface, particles, layout, roughness_of(c, kind), field ? &*field : nullptr,
                                softness, c.work().part(0.1, 0.65));
  textures::round_edges(maps.height, wear.rounding, -std::abs(wear.relief), c.work().part(0.65, 0.7));
  return maps;
}

TextureMaps maps_of_volume(Context& c, FinishKind kind) {
  if (kind == FinishKind::Broken || kind == FinishKind::Loose)
    throw Error("missing-input", "finish '" + c.text("finish") + "' needs the particles, which stay whole",
                "connect particles and shapes instead of the volume, or choose another finish")
        .parameter("finish");
  const auto& volume = c.input<Volume>("volume");
  const section::VolumeBox box = section::volume_box(volume);
  if (!box.periodic)
    throw Error("not-periodic", "the volume does not repeat, so a plane through it does not tile",
                "connect a periodic volume, for example from Voxelize or SolidOptimize");
  if (carving::has_voids(volume))
    c.warn("the voids of the volume are shown filled; connect particles and shapes to see the holes");
  const Wear wear = wear_of(c, kind, 2 * box.voxel, box.size);
  if (wear.relief != 0 && !volume.find<openvdb::FloatGrid>("density"))
    throw Error("no-such-grid",
                "finish '" + c.text("finish") +
                    "' needs the grid 'density' of the volume, which tells stones "
                    "from binder",
                "set finish to polished, or connect the particles instead of the volume")
        .parameter("finish");
  TextureMaps maps =
      paint_maps(volume, layout_of(c, box.size), wear.relief, roughness_of(c, kind), c.work().part(0, 0.65));
  textures::round_edges(maps.height, wear.rounding, -std::abs(wear.relief), c.work().part(0.65, 0.7));
  return maps;
}

void compute(Context& c) {
  textures::require_one_solid(c);
  const auto kind = c.choice<FinishKind>("finish");
  TextureMaps maps = c.has("volume") ? maps_of_volume(c, kind) : maps_of_particles(c, kind);
  for (Vec3f& color : maps.base_color.pixels) color = color.cwiseMax(0.0f).cwiseMin(1.0f);
  Image height(maps.height.width, maps.height.height, 1, maps.base_color.pixel_size);
  for (std::size_t i = 0; i < height.pixels.size(); ++i) height.pixels[i].setConstant(maps.height.mm[i]);
  const auto [low, high] = std::minmax_element(maps.height.mm.begin(), maps.height.mm.end());
  c.metric("pixel_size", maps.base_color.pixel_size);
  c.metric("height_min", double{*low});
  c.metric("height_max", double{*high});
  Image normal = textures::normal_map(maps.height, c.work());
  Image occlusion = textures::occlusion_map(maps.height, c.work().part(0.7, 1));
  c.output("preview", textures::lit_picture(maps.base_color, normal, maps.roughness, occlusion, c.work()));
  c.output("normal", std::move(normal));
  c.output("occlusion", std::move(occlusion));
  c.output("base_color", std::move(maps.base_color));
  c.output("height", std::move(height));
  c.output("roughness", std::move(maps.roughness));
  c.output("id", std::move(maps.id));
}

void declare_ports(NodeType& type) {
  type.optional_input("particles", {"Particles"}, "Packing in a periodic box. Requires shapes")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input("detail", {"Detail"},
                      "Fine detail from DetailSolid, added to the colors without the photograph's light. Not "
                      "used for volumes, whose colors contain it")
      .optional_input(
          "volume", {"Volume"},
          "Periodic volume instead of particles. Uses grid Cd or density, id, and density for relief")
      .output("base_color", "Image", "Color of the material without light, scene-linear")
      .output("normal", "Image",
              "Normal in tangent space as (n + 1) / 2: x to the right, y upwards (OpenGL's convention)")
      .output("height", "Image", "Height above the plane in mm, in all channels")
      .output("roughness", "Image", "Roughness, 0 to 1, in all channels")
      .output("occlusion", "Image", "Share of the sky that the relief leaves open, in all channels")
      .output("id", "Image",
              "A different color for each particle, black for the binder, without antialiasing")
      .output("preview", "Image", "The maps under a lamp, two periods wide, for display");
}

}  // namespace
}  // namespace terrazzo::texture_set

namespace terrazzo {

NodeType texture_set_node() {
  using namespace texture_set;
  NodeType type("TextureSet", 3);
  type.doc_(
          "Makes the texture maps of a plane through the solid, one period wide, so that they tile exactly: "
          "base "
          "color, normal, height, roughness, occlusion and particle ids.")
      .source_(
          "Edges: opening by a paraboloid, van den Boomgaard and Smeulders 1994. Broken faces: Bouchaud, "
          "Lapasset and Planès 1990. "
          "Occlusion: "
          "Jiménez et al. 2016, equation 7");
  declare_ports(type);
  return type
      .parameter(
          Parameter::choice("axis", "z", {"x", "y", "z"})
              .doc_("Axis perpendicular to the plane. x shows y to the right and z up, y shows x and z, z "
                    "shows x and y."))
      .parameter(Parameter::optional_number("position", "auto")
                     .unit_("mm")
                     .range(0, 1e9)
                     .doc_("Position of the plane along the axis, from the box's corner. auto: the middle."))
      .parameter(Parameter::integer("resolution", 2048)
                     .unit_("pixels")
                     .range(1, 16384)
                     .doc_("Pixels along the longer edge. Powers of two suit engines."))
      .parameter(
          Parameter::choice("finish", "polished", {"polished", "honed", "broken", "weathered", "loose"})
              .doc_("polished: flat, except for voids. honed, weathered: the binder is worn below the plane, "
                    "a little or much, and edges are rounded. broken: the binder breaks along a rough face, "
                    "particles stay whole or leave sockets. loose: no binder; particles whose center is "
                    "below the plane, as in gravel."))
      .parameter(
          Parameter::optional_number("relief", "auto")
              .unit_("mm")
              .range(-1e6, 1e6)
              .doc_("How far the binder of a honed or weathered face lies below the particles; if negative, "
                    "above them. Of a broken face: its standard deviation. auto: 0.01, 0.12 and 0.1 of the "
                    "mean particle size; for a volume, 2 voxels."))
      .parameter(
          Parameter::optional_number("rounding", "auto")
              .unit_("mm")
              .range(0, 1e6)
              .doc_("Radius of curvature at the top of the edges of a honed or weathered face. auto: half "
                    "the relief."))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "roughness", "auto")
                     .count(1, 64)
                     .range(0, 1)
                     .doc_("Roughness of particles where they are worn: one number, or one for each class. "
                           "auto: polished "
                           "0.15, honed 0.35, else 0.7. Broken and natural faces have 0.7."))
      .parameter(
          Parameter::optional_number("binder_roughness", "auto")
              .range(0, 1)
              .doc_(
                  "Roughness of the binder. auto: polished 0.4, honed 0.55, else 0.9, which is also that of "
                  "the walls of voids."))
      .parameter(Parameter::seed().doc_("Random seed of a broken face"))
      .compute_(compute);
}

}  // namespace terrazzo
