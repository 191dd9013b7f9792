#include "nodes/bodies/carving/request.h"

#include <fmt/format.h>

#include "graph/node_parameters.h"
#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/forms.h"
#include "nodes/bodies/carving/hidden_phases.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/data/detail.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/profiles.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/memory.h"

namespace terrazzo::carving {

const std::vector<std::string> kModes = {"auto", "block", "cube",     "object",
                                         "vase", "knot",  "fracture", "particles"};

namespace {

enum class ColorSource { Auto, Volume, Particles };

void need(const Context& c, const std::string& what, const std::string& input) {
  if (!c.has(input))
    throw Error("no-" + input, what + " needs the input '" + input + "', which is not connected",
                input == "volume" ? "connect a volume with colors, for example from Voxelize" : "connect it");
}

void need(const Context& c, Mode mode, const std::string& input) {
  need(c, "mode '" + kModes[static_cast<std::size_t>(mode)] + "'", input);
}

Placement placement_of(const NodeParameters& c) {
  const auto three = [&](const char* name) {
    const auto v = c.numbers(name);
    if (v.size() != 3)
      throw Error(std::string("bad-") + name, std::to_string(v.size()) + " numbers are given instead of 3",
                  "write x, y and z")
          .parameter(name);
    return Vec3(v[0], v[1], v[2]);
  };
  return Placement::of(three("turn"), three("shift"));
}

enum class Shown { Inside, Outside };

// Loads the fine detail of particles and binder, if connected: what a cut shows, or what the outside of
// photographed stones shows.
void take_residual(Context& c, Body& body, Shown shown) {
  const auto& particles = c.input<Particles>("particles");
  if (const auto* detail = c.optional<Detail>("detail")) {
    const auto use = [&](const Detail& fine) {
      body.residual = std::make_unique<residual::ResidualField>(fine, particles, 0, residual::Keep::Values,
                                                                c.work().part(0, 0.05));
    };
    if (shown == Shown::Inside || detail->tones.empty()) return use(*detail);
    body.skins = std::make_unique<residual::Skins>(*detail, particles, c.input<Shapes>("shapes"), 0,
                                                   std::nullopt, c.work().quiet());
    return use(residual::without_light(*detail));
  }
  const auto* volume = c.optional<Volume>("detail");
  if (!volume) return;
  body.residual = std::make_unique<residual::ResidualField>(*volume, particles.box, c.work().part(0, 0.05));
  const double scale = std::exp(body.residual->scale().array().log().abs().maxCoeff());
  c.metric("residual_scale", scale);
  if (scale > 1.25)
    c.warn(
        fmt::format("the residual is scaled by a factor of {:.3g} to tile the box; synthesize it in another "
                    "size to keep its scale",
                    scale));
}

// Sets up the color inside, from voxels or from the particles themselves.
void take_paint(Context& c, Mode mode, Body& body) {
  const double repeat = mode == Mode::Fracture ? 1 : c.number("repeat");
  auto color = c.choice<ColorSource>("color");
  if (mode == Mode::Fracture)
    color = ColorSource::Particles;
  else if (color == ColorSource::Auto)
    color = c.has("volume") || !c.has("particles") ? ColorSource::Volume : ColorSource::Particles;
  if (color == ColorSource::Particles) {
    need(c, "color from particles", "particles");
    need(c, "color from particles", "shapes");
    const auto& particles = c.input<Particles>("particles");
    check_shown(particles, c.input<Shapes>("shapes"));
    take_residual(c, body, Shown::Inside);
    body.mm = particles.box.maxCoeff() * repeat;
    body.paint = particle_paint(particles, c.input<Shapes>("shapes"), repeat,
                                mode == Mode::Fracture ? Placement{} : placement_of(c), body.residual.get());
    return;
  }
  need(c, mode, "volume");
  if (c.has("detail"))
    c.warn("the residual is not used, because colors come from the volume; set color: particles to use it");
  body.field =
      std::make_unique<ColorField>(ColorField::of(c.input<Volume>("volume"), c.work().part(0, 0.05)));
  if (body.field->clamped() > 0.01f)
    c.warn("colors outside 0 to 1 in " +
           std::to_string(static_cast<int>(100 * body.field->clamped() + 0.5f)) +
           " % of the voxels were clamped, since no surface reflects more light than it receives");
  body.mm = body.field->voxel() * body.field->resolution().maxCoeff() * repeat;
  body.paint = field_paint(*body.field, repeat, placement_of(c), mode == Mode::Block || mode == Mode::Cube);
}

// Makes holes of the phases of the volume that colors come from.
void take_hidden(Context& c, Mode mode, Body& body, const std::vector<std::int64_t>& hide) {
  if (!body.field)
    throw Error(
        "bad-value",
        "only phases of a volume that the body's colors come from can be hidden, in modes that carve it",
        "use mode block, cube, object, vase or knot with color: volume, or leave hide empty")
        .parameter("hide");
  const auto& volume = c.input<Volume>("volume");
  const Placement placed = placement_of(c);
  const bool inside = (mode == Mode::Block || mode == Mode::Cube) && c.number("repeat") <= 1 &&
                      placed.turn.isIdentity() && placed.shift.isZero();
  if (!volume.periodic() && !inside)
    throw Error("bad-value", "the body reaches beyond a volume that does not repeat",
                "use mode block or cube without repeat, turn and shift, or a volume that tiles")
        .parameter("hide");
  const auto* particles = c.optional<Particles>("particles");
  if (has_voids(volume) || (particles && particles->void_count() > 0))
    c.warn("phases are hidden, so the voids of the packing are shown filled");
  const HiddenVoxels hidden = hidden_voxels(volume, hide, c.work());
  require_memory(hidden_forecast(hidden, c.work()), c.memory(), "the surface of the hidden phases");
  body.field->cover(hidden, c.work());
  body.hidden = std::make_unique<HiddenVoid>(hidden_void(hidden, body.field->voxel(), c.work().quiet()));
}

// The holes in the carved body: hidden phases, or the voids of a packing.
Voids voids_of(Context& c, const Body& body) {
  if (body.hidden)
    return {&body.hidden->particles, &body.hidden->shapes, c.number("repeat"), placement_of(c),
            [hidden = body.hidden.get()](const Vec3f& p) { return hidden->holds(p); }};
  const auto* particles = c.optional<Particles>("particles");
  const auto* volume = c.optional<Volume>("volume");
  if (!particles && volume && has_voids(*volume))
    c.warn(
        "the volume has voids, which are shown filled; connect the particles and their shapes to see the "
        "holes");
  if (!particles || particles->void_count() == 0) return {};
  need(c, "a packing with voids", "shapes");
  return {particles, &c.input<Shapes>("shapes"), c.number("repeat"), placement_of(c)};
}

void take_solid(Context& c, Mode mode, Body& body, std::uint64_t seed) {
  const Paint* paint = body.paint.get();
  if (mode != Mode::Fracture && mode != Mode::Particles) body.voids = voids_of(c, body);
  if (mode == Mode::Block) body.solid = block_solid(*paint, c.number("cut"), kBevel, body.voids);
  if (mode == Mode::Cube) body.solid = block_solid(*paint, 0, kBevel, body.voids);
  if (mode == Mode::Vase) body.solid = object_solid(*paint, vase_form(), body.voids);
  if (mode == Mode::Knot) body.solid = object_solid(*paint, knot_form(), body.voids);
  if (mode == Mode::Object) body.solid = object_solid(*paint, object_of(c, true), body.voids);
  if (body.solid) return;
  need(c, mode, "particles");
  need(c, mode, "shapes");
  const auto& particles = c.input<Particles>("particles");
  const auto& shapes = c.input<Shapes>("shapes");
  if (mode == Mode::Fracture) {
    body.solid = fracture_solid(*paint, particles, shapes, c.number("level"), c.number("roughness"), seed,
                                body.residual.get());
    return;
  }
  check_shown(particles, shapes);
  take_residual(c, body, Shown::Outside);
  body.mm = particles.box.maxCoeff();
  body.solid = particle_solid(particles, shapes, body.residual.get(), body.skins.get());
}

}  // namespace

Body::Body() = default;
Body::~Body() = default;
Body::Body(Body&&) noexcept = default;

Mode resolved_mode(const Context& c, const Profiles* photograph) {
  const auto mode = c.choice<Mode>("mode");
  if (mode != Mode::Auto) return mode;
  if (photograph && c.has("particles") && shows_loose_stones(*photograph)) return Mode::Particles;
  if (c.has("object")) return Mode::Object;
  return c.has("volume") || photograph || !c.has("particles") ? Mode::Block : Mode::Particles;
}

void check_body(const NodeParameters& p) { placement_of(p); }

Body body_of(Context& c, Mode mode, std::uint64_t seed, const std::vector<std::int64_t>& hide) {
  Body body;
  if (mode != Mode::Particles) take_paint(c, mode, body);
  if (!hide.empty()) take_hidden(c, mode, body, hide);
  take_solid(c, mode, body, seed);
  return body;
}

const Shape& object_of(Context& c, bool warn) {
  need(c, Mode::Object, "object");
  const Shapes& shapes = c.input<Shapes>("object");
  if (shapes.shapes.empty()) throw Error("no-shapes", "the object has no mesh");
  if (warn && shapes.shapes.size() > 1)
    c.warn("the object has " + std::to_string(shapes.shapes.size()) + " meshes; only the first, '" +
           shapes.shapes[0].name + "', is used");
  return shapes.shapes[0];
}

void declare_solid(NodeType& type) {
  type.optional_input("volume", {"Volume"},
                      "Solid: a color grid `Cd`, or phases in the grid `phase`, repeated periodically")
      .optional_input("particles", {"Particles"},
                      "Packing whose solid is used at full resolution. Its voids are holes in carved bodies, "
                      "even if colors come from the volume.")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input("object", {"Shapes"}, "Body to carve from the solid")
      .optional_input("detail", {"Detail", "Volume"},
                      "Fine detail of particles and binder from DetailSolid, or a volume with the grid "
                      "residual from ResidualSynth. Used only with colors from particles.");
}

void declare_body(NodeType& type) {
  type.parameter(Parameter::choice("color", "auto", {"auto", "volume", "particles"})
                     .doc_("Source of the colors of carved bodies. volume: its voxels. particles: particles "
                           "and binder at full resolution. auto: volume if one is connected, else particles. "
                           "A fracture always uses particles."))
      .parameter(Parameter::number("repeat", 1)
                     .range(0.05, 64)
                     .doc_("Periods of the volume along the longest edge of the block or object"))
      .parameter(Parameter::numbers("turn", {0, 0, 0})
                     .count(3, 3)
                     .range(-360, 360)
                     .unit_("degrees")
                     .doc_("Rotation of the solid in the body carved from it, around x, then y, then z. "
                           "Faces oblique to its period show no repetition."))
      .parameter(Parameter::numbers("shift", {0, 0, 0})
                     .count(3, 3)
                     .range(-1000, 1000)
                     .doc_("Shift of the solid in the body carved from it, in periods of x, y and z"))
      .parameter(
          Parameter::number("cut", 0.5).range(0.05, 0.95).doc_("Fraction of each edge that is cut out"))
      .parameter(Parameter::number("level", 0.6)
                     .range(0, 1)
                     .doc_("Height of the broken face of a fracture, as a fraction of the block's height"))
      .parameter(Parameter::number("roughness", 0.05)
                     .range(0, 0.5)
                     .doc_("Amplitude of the binder's face in a fracture, up and down, as a fraction of the "
                           "block's height"));
}

}  // namespace terrazzo::carving
