#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "graph/node_type.h"
#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/cutting/cut.h"
#include "nodes/bodies/cutting/volume_section.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/volume.h"
#include "nodes/textures/bake/bake_maps.h"
#include "nodes/textures/bake/box_atlas.h"
#include "nodes/textures/bake/mesh_shadow.h"
#include "runtime/context.h"

namespace terrazzo::bake {
namespace {

enum class Unwrapping { Auto, Mesh, Atlas };  // in the order of the parameter's words

void require_memory_for_maps(const Context& c) {
  constexpr double kTexel = 130;     // bytes: six maps of three floats, and what makes and stores them
  constexpr double kTriangle = 360;  // its place, its coordinates, and its edges in an atlas
  constexpr double kVoxel = 24;      // colors, and densities while they become a field
  const double edge = static_cast<double>(c.integer("resolution"));
  double triangles = 0, voxels = 0;
  for (const Shape& s : c.input<Shapes>("mesh").shapes) triangles += count_of(s.mesh.triangles);
  if (const Volume* volume = c.optional<Volume>("volume"))
    voxels = static_cast<double>(voxels_of(*volume).volume());
  const double bytes = edge * edge * kTexel + triangles * kTriangle + voxels * kVoxel;
  if (bytes <= static_cast<double>(c.memory())) return;
  throw Error(
      "too-large",
      fmt::format("maps of {0:.0f} × {0:.0f} pixels, {1:.3g} triangles and {2:.3g} voxels need about "
                  "{3:.1f} GB of memory, but only {4:.1f} GB are available",
                  edge, triangles, voxels, bytes / 1e9, static_cast<double>(c.memory()) / 1e9),
      "lower resolution, use a smaller mesh or volume, or raise --memory if the machine has more memory")
      .parameter("resolution");
}

bool has_atlas(const Context& c, const Shape& mesh) {
  return c.choice<Unwrapping>("uv") == Unwrapping::Atlas || mesh.uv.empty();
}

// Gives the mesh new texture coordinates.
void unwrap(Context& c, Shape& mesh) {
  const int size = static_cast<int>(c.integer("resolution")),
            padding = static_cast<int>(c.integer("padding"));
  if (c.choice<Unwrapping>("uv") == Unwrapping::Auto)
    c.warn("the mesh has no texture coordinates; output mesh has new ones, which the maps fit");
  BoxAtlas atlas = box_atlas(mesh.mesh, size, 2 * padding + 1, c.work().part(0, 0.05));
  mesh.uv = std::move(atlas.uv);
  if (const int fits = (atlas.gap - 1) / 2; fits < padding)
    c.warn(fmt::format(
        "the charts of the new coordinates are many, so that padding reaches only {} of {} pixels; raise "
        "resolution, lower padding, or unwrap the mesh in a mesh editor",
        fits, padding));
}

// The mesh with the texture coordinates that the maps have.
Shape unwrapped_mesh(Context& c) {
  const auto& meshes = c.input<Shapes>("mesh");
  if (meshes.shapes.size() != 1)
    throw Error("one-shape-only",
                fmt::format("mesh has {} shapes, but a texture shows one", meshes.shapes.size()),
                "connect LoadMesh with surface: true, which reads a file as one shape");
  Shape mesh = meshes.shapes[0];
  for (const Vec3& v : mesh.mesh.vertices)
    if (!v.allFinite())
      throw Error("bad-mesh", "a vertex of the mesh is NaN or infinite",
                  "remove it in a mesh editor, or export the mesh again");
  if (c.choice<Unwrapping>("uv") == Unwrapping::Mesh && mesh.uv.empty())
    throw Error(
        "no-uv", "the mesh has no texture coordinates",
        "set uv to auto or atlas, or load a .obj, .glb or .gltf file that has them with surface: true")
        .parameter("uv");
  if (has_atlas(c, mesh)) unwrap(c, mesh);
  return mesh;
}

void warn_of_texels(Context& c, const UvTexels& texels, std::size_t triangles, bool atlas) {
  const double share = static_cast<double>(texels.overlapping) / static_cast<double>(texels.covered);
  c.metric("covered", static_cast<double>(texels.covered) / static_cast<double>(texels.triangle.size()));
  c.metric("overlapping", share);
  if (texels.overlapping > 0)
    c.warn(fmt::format(
        "{:.3g} % of the texels belong to several triangles, which lie elsewhere on the mesh; they "
        "show the first of them. {}",
        100 * share,
        atlas ? "A part of the mesh folds over itself as seen from its side: unwrap it in a mesh editor"
              : "Unwrap the mesh without overlaps, or set uv: atlas"));
  if (texels.outside > 0)
    c.warn(
        fmt::format("{} of {} triangles leave the texture, which repeats: UV coordinates outside 0 to 1 are "
                    "wrapped, and tiles of UDIM share one map",
                    texels.outside, triangles));
  if (texels.without_area > 0)
    c.warn(fmt::format("{} of {} triangles have no area and are skipped", texels.without_area, triangles));
}

// What particles show, but a volume does not.
void warn_of_unused(Context& c) {
  if (!c.has("volume")) return;
  if (carving::has_voids(c.input<Volume>("volume")))
    c.warn("the voids of the volume are shown filled; connect particles and shapes to see their walls");
  if (c.has("detail")) c.warn("the detail is not used, since the colors of a volume contain it");
  if (!c.keyword("roughness").empty()) return;
  if (const std::size_t values = c.numbers("roughness").size(); values > 1)
    c.warn(fmt::format(
        "roughness has {} values, but a volume has no classes: all particles have the first one", values));
}

// Mean length of a texel on the mesh, mm. Each triangle that a texel shows counts once: neither padding nor
// the few texels of slivers weigh more than their area.
double mean_texel(const Shape& mesh, const UvTexels& texels, double scale) {
  std::vector<bool> shown(mesh.uv.size(), false);
  for (const std::int32_t t : texels.triangle)
    if (t >= 0) shown[t] = true;
  double area = 0, in_texture = 0;
  for (std::size_t t = 0; t < shown.size(); ++t) {
    if (!shown[t]) continue;
    const auto& [a, b, c] = mesh.mesh.triangles[t];
    const Vec3& corner = mesh.mesh.vertices[a];
    area += (mesh.mesh.vertices[b] - corner).cross(mesh.mesh.vertices[c] - corner).norm();
    const Eigen::Vector2d u = (mesh.uv[t][1] - mesh.uv[t][0]).cast<double>();
    const Eigen::Vector2d v = (mesh.uv[t][2] - mesh.uv[t][0]).cast<double>();
    in_texture += std::abs(u.x() * v.y() - u.y() * v.x());
  }
  return scale * std::sqrt(area / in_texture) / texels.size;
}

// States how large the mesh is in the solid, and warns if that looks like another unit of length.
void compare_sizes(Context& c, const Mesh& mesh, double scale, double period) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  const double size = scale * box.sizes().maxCoeff(), periods = size / period;
  c.metric("mesh_size", size);
  c.metric("periods", periods);
  const std::string what = fmt::format("the mesh is {:.4g} mm large at scale {:g}", size, scale);
  if (periods > 4)
    c.warn(fmt::format(
        "{}, {:.3g} periods of the solid ({:.4g} mm): its pattern repeats. Make a larger solid, or "
        "lower scale if the mesh has another unit than mm",
        what, periods, period));
  if (periods < 0.1)
    c.warn(
        fmt::format("{}, {:.2g} of the solid's period of {:.4g} mm. Raise scale if the mesh has another unit "
                    "than mm: 1000 for meters",
                    what, periods, period));
}

textures::Roughness roughness_of(const Context& c) {
  textures::Roughness out;
  out.particles = {textures::Roughness::kPolishedParticle};
  if (c.keyword("roughness").empty()) out.particles = c.numbers("roughness");
  out.binder = c.optional_number("binder_roughness").value_or(textures::Roughness::kPolishedBinder);
  return out;
}

BakedMaps maps_of_particles(Context& c, const UvTexels& texels, const TexelPlaces& places, double texel) {
  const auto& particles = c.input<Particles>("particles");
  const Work work = c.work().part(0.1, 0.8);
  std::optional<residual::ResidualField> field;
  double softness = 0;
  if (const Detail* detail = c.optional<Detail>("detail")) {
    textures::check_softness(*detail, texel, "scale",
                             "raise scale if the mesh has another unit than mm, or lower resolution");
    field.emplace(textures::unlit(*detail), particles, texel, residual::Keep::Power, work.part(0, 0.2));
    softness = detail->softness * detail->pixel_size / texel;
  }
  return bake_particles(texels, places, particles, c.input<Shapes>("shapes"), roughness_of(c),
                        field ? &*field : nullptr, softness, work.part(0.2, 1));
}

// The period of the solid. Refuses solids that cannot be baked.
Vec3 checked_period(Context& c) {
  textures::require_one_solid(c);
  if (!c.has("volume")) {
    const auto& particles = c.input<Particles>("particles");
    section::check_particles(particles, c.input<Shapes>("shapes"));
    return particles.box;
  }
  const auto& volume = c.input<Volume>("volume");
  const section::VolumeBox box = section::volume_box(volume);
  if (!box.periodic)
    throw Error("not-periodic", "the volume does not repeat, so it does not reach everywhere on a mesh",
                "connect a periodic volume, for example from Voxelize or SolidOptimize");
  if (c.number("relief") != 0 && !volume.find<openvdb::FloatGrid>("density"))
    throw Error("no-such-grid",
                "relief needs the grid 'density' of the volume, which tells stones from binder",
                "set relief to 0, or connect the particles instead of the volume")
        .parameter("relief");
  return box.size;
}

double checked_relief(const Context& c, const Vec3& period) {
  const double relief = c.number("relief");
  if (std::abs(relief) > period.minCoeff() / 2)
    throw Error(
        "bad-value",
        fmt::format("relief is {:g} mm, but the solid repeats after {:g} mm", relief, period.minCoeff()),
        fmt::format("relief must be at most {:g} mm", period.minCoeff() / 2))
        .parameter("relief");
  return relief;
}

// Texels of no triangle continue the nearest one, so that they are no pit or wall beside it.
textures::HeightField heights_of(const UvTexels& texels, std::vector<float> cover, double relief,
                                 double texel, const Work& work) {
  const int size = texels.size;
  textures::HeightField out{size, size, texel, texel, std::vector<float>(cover.size(), 0.0f)};
  if (relief == 0) return out;
  extend_to_blanks(texels, cover, work.part(0, 0.5));
  for (std::size_t i = 0; i < out.mm.size(); ++i) {
    const double share = std::clamp(double{cover[i]}, 0.0, 1.0);
    out.mm[i] = static_cast<float>(-(relief > 0 ? relief * (1 - share) : -relief * share));
  }
  textures::round_edges(out, std::abs(relief) / 2, -std::abs(relief), work.part(0.5, 1));
  return out;
}

// The maps of the relief: normal, height and occlusion, and of the mesh in the last.
void put_relief(Context& c, const Shape& mesh, const UvTexels& texels, const TexelPlaces& places,
                std::vector<float> cover, double relief, double texel) {
  const textures::HeightField h =
      heights_of(texels, std::move(cover), relief, texel, c.work().part(0.8, 0.85));
  c.output("normal", normals_on_mesh(texels, places, h, c.work().part(0.85, 0.9)));
  Image occlusion = textures::occlusion_map(h, c.work().part(0.9, 0.92));
  if (c.boolean("shadow")) {
    const UvTexels inside = find_texels(mesh.mesh, mesh.uv, texels.size, 0, c.work().quiet());
    const auto open = open_sky(mesh.mesh, inside, places, c.number("scale"), c.work().part(0.92, 1));
    for (std::size_t i = 0; i < open.size(); ++i) occlusion.pixels[i] *= open[i];
  }
  Image height(texels.size, texels.size, 1, texel);
  const float blank = relief > 0 ? static_cast<float>(-relief) : 0.0f;  // binder, as in the base color
  for (std::size_t i = 0; i < height.pixels.size(); ++i) {
    const bool shown = texels.triangle[i] >= 0;
    height.pixels[i].setConstant(shown ? h.mm[i] : blank);
    if (!shown) occlusion.pixels[i].setOnes();
  }
  c.output("occlusion", std::move(occlusion));
  c.output("height", std::move(height));
}

void compute(Context& c) {
  const Vec3 period = checked_period(c);
  const double relief = checked_relief(c, period), scale = c.number("scale");
  require_memory_for_maps(c);
  warn_of_unused(c);
  Shape mesh = unwrapped_mesh(c);
  const int size = static_cast<int>(c.integer("resolution"));
  const UvTexels texels =
      find_texels(mesh.mesh, mesh.uv, size, static_cast<int>(c.integer("padding")), c.work().part(0.05, 0.1));
  const TexelPlaces places(mesh.mesh, mesh.uv, size, scale, c.work());
  warn_of_texels(c, texels, mesh.mesh.triangles.size(), has_atlas(c, c.input<Shapes>("mesh").shapes[0]));
  compare_sizes(c, mesh.mesh, scale, period.minCoeff());
  const double texel = mean_texel(mesh, texels, scale);
  c.metric("pixel_size", texel);
  BakedMaps maps = c.has("volume") ? bake_volume(texels, places, c.input<Volume>("volume"), roughness_of(c),
                                                 c.work().part(0.1, 0.8))
                                   : maps_of_particles(c, texels, places, texel);
  for (Vec3f& color : maps.base_color.pixels) color = color.cwiseMax(0.0f).cwiseMin(1.0f);
  put_relief(c, mesh, texels, places, std::move(maps.cover), relief, texel);
  for (Image* image : {&maps.base_color, &maps.roughness, &maps.id}) image->pixel_size = texel;
  c.output("base_color", std::move(maps.base_color));
  c.output("roughness", std::move(maps.roughness));
  c.output("id", std::move(maps.id));
  Shapes out;
  out.shapes.push_back(std::move(mesh));
  c.output("mesh", std::move(out));
}

void declare_ports(NodeType& type) {
  type.input("mesh", {"Shapes"},
             "One shape, for example a surface of LoadMesh, with or without UV coordinates")
      .optional_input("particles", {"Particles"}, "Packing in a periodic box. Requires shapes")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input("detail", {"Detail"},
                      "Fine detail from DetailSolid, added to the colors without the photograph's light. Not "
                      "used for volumes, whose colors contain it")
      .optional_input("volume", {"Volume"},
                      "Periodic volume instead of particles. Uses grid Cd, id, and density for relief")
      .output("base_color", "Image", "Color of the material without light, scene-linear")
      .output("normal", "Image",
              "Normal in tangent space as (n + 1) / 2: x to the right, y upwards (OpenGL's convention)")
      .output("height", "Image",
              "Height above the mesh in mm of the solid, in all channels; 0 without relief")
      .output("roughness", "Image", "Roughness, 0 to 1, in all channels")
      .output("occlusion", "Image",
              "Share of the sky that the relief and the mesh leave open, in all channels")
      .output("id", "Image",
              "A different color for each particle, black for the binder, without antialiasing")
      .output("mesh", "Shapes", "The mesh with the texture coordinates of the maps");
}

}  // namespace
}  // namespace terrazzo::bake

namespace terrazzo {

NodeType bake_node() {
  using namespace bake;
  NodeType type("Bake", 4);
  type.doc_(
      "Makes the texture maps of a mesh that is carved from the solid: base color, normal, height, "
      "roughness, "
      "occlusion and particle ids. Each texel shows the solid at its place in space, so no seam shows.");
  declare_ports(type);
  return type
      .parameter(Parameter::integer("resolution", 2048)
                     .unit_("pixels")
                     .range(1, 16384)
                     .doc_("Pixels along an edge of the square maps"))
      .parameter(
          Parameter::number("scale", 1)
              .range(1e-9, 1e9)
              .doc_("Millimeters of the solid per millimeter of the mesh. Less than 1 makes the stones "
                    "larger. The origin of the mesh is a corner of the solid's box."))
      .parameter(
          Parameter::choice("uv", "auto", {"auto", "mesh", "atlas"})
              .doc_("mesh: the mesh's own UV coordinates, wrapped outside 0 to 1. atlas: new ones, projected "
                    "from six sides. auto: those of the mesh if it has any."))
      .parameter(
          Parameter::integer("padding", 16)
              .unit_("pixels")
              .range(0, 256)
              .doc_("How far the maps continue beyond the edges of triangles, for filters and MIP levels"))
      .parameter(
          Parameter::number("relief", 0)
              .unit_("mm")
              .range(-1e6, 1e6)
              .doc_("How far the binder lies below the particles, in mm of the solid; if negative, above "
                    "them. 0: polished. Edges are rounded with half the relief as radius of curvature."))
      .parameter(
          Parameter::boolean("shadow", true)
              .doc_("Whether occlusion contains what the mesh hides of the sky, such as in its folds and "
                    "cavities"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "roughness", "auto")
                     .count(1, 64)
                     .range(0, 1)
                     .doc_("Roughness of particles: one number, or one for each class. auto: 0.15"))
      .parameter(Parameter::optional_number("binder_roughness", "auto")
                     .range(0, 1)
                     .doc_("Roughness of the binder. auto: 0.4. Walls of voids have 0.9."))
      .compute_(compute);
}

}  // namespace terrazzo
