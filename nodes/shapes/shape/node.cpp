#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/closed_form.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape/stones.h"
#include "nodes/shapes/shape/wear.h"
#include "runtime/context.h"

namespace terrazzo::shape {
namespace {

bool is_stone(SolidKind kind) { return kind >= SolidKind::Rock; }

// A solid of arbitrary scale with its exact measures.
struct Solid {
  Mesh mesh;
  ClosedForm exact;
  bool smooth = false;
};

Vec3 axes_of(const NodeParameters& c) {
  const auto a = c.numbers("axes");
  const Vec3 axes(a[0], a[1], a[2]);
  if (axes.maxCoeff() > 1000 * axes.minCoeff())
    throw Error("bad-axes",
                fmt::format("the longest of the axes is {:.4g} times the shortest; at most 1000 is allowed",
                            axes.maxCoeff() / axes.minCoeff()),
                "choose axes within a factor of 1000")
        .parameter("axes");
  return axes / axes.maxCoeff();
}

Solid solid(const Context& c, SolidKind kind) {
  const Vec3 axes = axes_of(c);
  const int detail = c.integer("detail");
  const bool equal = axes.minCoeff() == axes.maxCoeff();
  if (kind == SolidKind::Sphere) return {ellipsoid_mesh(Vec3::Ones(), detail), sphere_closed_form(1), true};
  if (kind == SolidKind::Ellipsoid) return {ellipsoid_mesh(axes, detail), ellipsoid_closed_form(axes), true};
  if (kind == SolidKind::Box) return {box_mesh(axes), box_closed_form(axes), false};
  if (kind == SolidKind::Cylinder) return {cylinder_mesh(axes, detail), cylinder_closed_form(axes), false};
  if (kind == SolidKind::Superquadric) {
    const auto e = c.numbers("exponents");
    return {superquadric_mesh(axes, e[0], e[1], detail), superquadric_closed_form(axes, e[0], e[1]),
            std::min(e[0], e[1]) >= 0.5 && std::max(e[0], e[1]) <= 1.5};
  }
  Solid s{platonic_mesh(kind), {}, false};
  if (equal) s.exact = platonic_closed_form(kind, 1);
  for (auto& v : s.mesh.vertices) v = v.cwiseProduct(axes);
  return s;
}

// Replaces the tessellation's measures with exact ones, then scales everything to the particle size `size`.
Shape sized(std::string name, Solid s, double size, double probability, const Work& work) {
  Shape shape = measure_shape(std::move(name), std::move(s.mesh), probability, work);
  shape.smooth = s.smooth;
  shape.volume = s.exact.volume.value_or(shape.volume);
  shape.surface_area = s.exact.surface_area.value_or(shape.surface_area);
  shape.mean_caliper = s.exact.mean_caliper.value_or(shape.mean_caliper);
  shape.max_section_area = s.exact.max_section_area.value_or(shape.max_section_area);
  const double k = size / std::sqrt(4 * shape.max_section_area / std::numbers::pi);
  for (auto& v : shape.mesh.vertices) v *= k;
  shape.volume *= k * k * k;
  shape.surface_area *= k * k;
  shape.mean_caliper *= k;
  shape.max_section_area = std::numbers::pi / 4 * size * size;
  return shape;
}

void check(const NodeParameters& p) {
  const auto kind = p.choice<SolidKind>("kind");
  const Vec3 axes = axes_of(p);
  if (kind == SolidKind::Sphere && axes.minCoeff() != axes.maxCoeff())
    throw Error("bad-axes", "the axes of a sphere must be equal", "use kind: ellipsoid").parameter("axes");
  if (!is_stone(kind) && p.integer("count") != 1)
    throw Error("bad-count",
                fmt::format("count must be 1 for kind {}; it is {}", p.text("kind"), p.integer("count")),
                "set count to 1, or kind to a stone (rock, pebble, shard, clinker)")
        .parameter("count");
}

constexpr std::uint64_t kWear = 125;  // stream of random numbers

// Wears and roughens a stone, each relative to the diameter of a ball of its volume then.
void weather(Mesh& mesh, double wear, double roughness, const Context& c, std::int64_t item,
             const Work& work) {
  const auto diameter = [&] { return std::cbrt(6 * mesh_volume(mesh) / std::numbers::pi); };
  if (wear > 0) round_edges(mesh, wear * diameter(), work);
  if (roughness > 0) roughen(mesh, roughness * diameter() / 2, diameter(), Random(c.seed(), kWear, item));
}

void compute(Context& c) {
  const auto kind = c.choice<SolidKind>("kind");
  const std::string name = c.text("kind");
  const double size = c.number("size");
  const double wear = c.number("wear");
  // Wear would smooth the roughness of a rock's faces, so worn rocks get theirs afterwards, as other stones.
  const bool rock_is_rough = kind == SolidKind::Rock && wear == 0;
  const double roughness = c.optional_number("roughness").value_or(kind == SolidKind::Rock ? 0.02 : 0);
  const double rough_last = rock_is_rough ? 0 : roughness;
  Shapes shapes;
  const auto add_stones = [&](auto options, const auto& mesh_of, bool smooth) {
    const auto count = c.integer("count");
    for (std::int64_t i = 0; i < count; ++i) {
      const auto part = c.work().part(static_cast<double>(i) / count, (i + 1.0) / count);
      options.item = i;
      Mesh mesh = mesh_of(options, part);
      weather(mesh, wear, rough_last, c, i, part);
      shapes.shapes.push_back(sized(count > 1 ? fmt::format("{} {}", name, i + 1) : name,
                                    {std::move(mesh), {}, smooth}, size, 1.0 / count, part));
    }
  };
  if (kind == SolidKind::Rock) {
    RockOptions o;
    o.seed = c.seed();
    o.axes = axes_of(c);
    o.facets = c.integer("facets");
    o.chips = c.integer("chips");
    o.roughness = rock_is_rough ? roughness : 0;
    o.detail = c.integer("detail");
    add_stones(o, rock_mesh, false);
  } else if (is_stone(kind)) {
    StoneOptions o;
    o.kind = kind;
    o.seed = c.seed();
    o.axes = axes_of(c);
    o.detail = c.integer("detail");
    add_stones(o, stone_mesh, kind != SolidKind::Shard);
  } else {
    shapes.shapes.push_back(sized(name, solid(c, kind), size, 1, c.work()));
  }
  double triangles = 0, volume = 0, caliper = 0;
  for (const auto& s : shapes.shapes) {
    triangles += s.mesh.triangles.size();
    volume += s.probability * s.volume;
    caliper += s.probability * s.mean_caliper;
  }
  c.metric("shapes", shapes.shapes.size());
  c.metric("triangles", triangles);
  c.metric("volume", volume);
  c.metric("mean_caliper", caliper);
  c.output("shapes", std::move(shapes));
}

}  // namespace
}  // namespace terrazzo::shape

namespace terrazzo {

NodeType shape_node() {
  using namespace shape;
  return NodeType("Shape", 2)
      .doc_(
          "Creates an elementary solid, a superquadric, or random stones. Volume, surface area, mean caliper "
          "diameter and largest section are exact where a closed form is implemented.")
      .source_("closed forms: Santaló 1976; superquadrics: Barr 1981")
      .output("shapes", "Shapes", "One shape, or `count` different stones of equal probability")
      .parameter(
          Parameter::choice(
              "kind", "sphere",
              {"sphere", "ellipsoid", "box", "cylinder", "tetrahedron", "octahedron", "dodecahedron",
               "icosahedron", "superquadric", "rock", "pebble", "shard", "clinker"})
              .doc_("Kind of solid. The stones are random: rock is angular; pebble is worn smooth; shard is "
                    "elongated with a few flat sides; clinker is lobed, bent and far from convex."))
      .parameter(Parameter::number("size", 1).unit_("mm").range(1e-9, 1e9).doc_(
          "Particle size √(4·A_max/π), where A_max is the area of the largest plane section; for a sphere, "
          "the diameter"))
      .parameter(Parameter::numbers("axes", {1, 1, 1})
                     .count(3, 3)
                     .range(1e-9, 1e9)
                     .doc_("Proportions along x, y, z: the diameters of an ellipsoid, the edges of a box, "
                           "the width, depth and height of a cylinder, the mean proportions of a stone. Only "
                           "their ratios matter; `size` sets the scale."))
      .parameter(Parameter::numbers("exponents", {0.4, 0.4})
                     .count(2, 2)
                     .range(0.1, 2.5)
                     .doc_("Exponents of a superquadric, along z and around z. Near 0: box. 1: ellipsoid. 2: "
                           "octahedron."))
      .parameter(Parameter::seed().doc_("Random seed of the stones"))
      .parameter(Parameter::integer("count", 1).range(1, 100).doc_("Number of different stones"))
      .parameter(
          Parameter::integer("facets", 13).range(4, 30).doc_("Number of large fracture faces of a rock"))
      .parameter(
          Parameter::integer("chips", 6).range(0, 20).doc_("Number of corners and edges broken off a rock"))
      .parameter(
          Parameter::optional_number("roughness", "auto")
              .range(0, 0.1)
              .doc_("Standard deviation of the roughness of a stone's faces, relative to its radius. auto: "
                    "0.02 for a rock, 0 for other stones."))
      .parameter(Parameter::number("wear", 0).range(0, 0.25).doc_(
          "Radius of the worn edges of a stone, relative to its diameter. Roughness is added after "
          "wear."))
      .parameter(Parameter::integer("detail", 3)
                     .range(0, 6)
                     .doc_("Tessellation level: 20·4^detail triangles for a sphere and for pebble, shard and "
                           "clinker, about 60·2^detail for a rock"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
