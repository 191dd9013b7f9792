#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/gl/open_gl.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/table.h"
#include "nodes/volumes/render_volume/gl_march.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace render_volume;

enum class Mode { Textured, Plain };

Error bad(const char* parameter, const std::string& what, const std::string& hint) {
  return Error(std::string("bad-") + parameter, what, hint).parameter(parameter);
}

template <std::size_t N>
std::array<double, N> exactly(const Context& c, const char* name) {
  const auto v = c.numbers(name);
  if (v.size() != N)
    throw bad(name, fmt::format("{} has {} numbers", name, v.size()), fmt::format("write {} numbers", N));
  std::array<double, N> out{};
  std::copy(v.begin(), v.end(), out.begin());
  return out;
}

Look look_of(const Context& c) {
  Look l;
  l.width = c.integer("width");
  l.height = c.integer("height");
  l.samples = c.integer("samples");
  l.step = c.number("step");
  l.textured = c.choice<Mode>("mode") == Mode::Textured;
  l.scales = exactly<kScales>(c, "scales");
  l.weights = exactly<kScales>(c, "weights");
  if (!(l.weights[0] + l.weights[1] + l.weights[2] > 0))
    throw bad("weights", "all weights are 0", "make at least one of them positive");
  l.turning = c.choice<Turning>("turning");
  const auto window = exactly<2>(c, "window");
  l.window = Vec2(window[0], window[1]);
  if (!(window[1] > window[0]))
    throw bad("window", fmt::format("window goes from {} to {}", window[0], window[1]),
              "write the lower density first");
  l.modulation = c.number("modulation");
  l.opacity = c.number("opacity");
  l.ambient = c.number("ambient");
  l.translucency = c.number("translucency");
  l.penetration = c.number("penetration");
  const auto lamp = exactly<3>(c, "lamp");
  l.lamp = Vec3(lamp[0], lamp[1], lamp[2]);
  if (!(l.lamp.norm() > 1e-6))
    throw bad("lamp", "the lamp has no direction", "write three numbers that are not all 0");
  l.skin_noise = c.number("skin_noise");
  l.skin_scale = c.number("skin_scale");
  const auto clip = exactly<6>(c, "clip");
  for (int k = 0; k < 3; ++k) {
    l.clip[0][k] = clip[2 * k];
    l.clip[1][k] = clip[2 * k + 1];
    if (!(l.clip[1][k] > l.clip[0][k]))
      throw bad(
          "clip",
          fmt::format("the clip from {} to {} leaves nothing of {}", clip[2 * k], clip[2 * k + 1], "xyz"[k]),
          "write x from, to, y from, to, z from, to, as fractions of the edges");
  }
  l.up = c.choice<int>("up");
  l.azimuth = c.number("azimuth");
  l.elevation = c.number("elevation");
  l.zoom = c.number("zoom");
  const auto b = c.numbers("background");
  l.background = Vec3f(float(b[0]), float(b[1]), float(b[2]));
  l.seed = c.seed();
  return l;
}

void check(const NodeParameters& p) {
  if (p.number("translucency") > 0 && p.choice<Device>("device") != Device::Cpu)
    throw Error("bad-value",
                fmt::format("translucency is {}, but the shader of device {} has none",
                            p.number("translucency"), p.text("device")),
                "set device: cpu, or translucency: 0")
        .parameter("device");
}

// Shows the first frame with few rays.
void show_coarse(Context& c, Scene& scene, const Bricks& bricks) {
  constexpr double kRays = 20000;
  const Look look = scene.look;
  const double reduced = std::min(1.0, std::sqrt(kRays / (double(look.width) * look.height)));
  scene.look.width = std::max<int>(1, reduced * look.width);
  scene.look.height = std::max<int>(1, reduced * look.height);
  scene.look.samples = 1;
  Image image(scene.look.width, scene.look.height, 1, 1);
  FrameCounts ignored;
  image.pixels = march(scene, frame_of(scene, look.azimuth), bricks, ignored, c.work().quiet());
  scene.look = look;
  c.preview("image", std::move(image));
}

void compute(Context& c) {
  const Look look = look_of(c);
  std::vector<Tissue> tissues = parse_tissues(c.texts("classes"));
  ScanField scan = scan_field(c.input<Volume>("volume"), c.text("grid"), c.work().part(0, 0.1));
  std::vector<SolidTexture> textures;
  for (const Value& v : c.list("textures"))
    textures.push_back(SolidTexture::of(v.as<Volume>(), c.work().quiet()));
  Scene scene(std::move(scan), std::move(tissues), std::move(textures), look);
  const Bricks bricks(scene.scan, scene.intervals, c.work().part(0.1, 0.2));
  if (bricks.visible_share() == 0) {
    const double high = scene.scan.low + 65535.0 * scene.scan.step;
    c.warn(
        fmt::format("the picture is empty: no class contains any of the volume's densities, {:.6g} to {:.6g}",
                    scene.scan.low, high));
  }
  c.metric("visible_bricks", bricks.visible_share());

  const int frames = c.integer("frames");
  const auto gl = open_gl(
      c, "rendered", [&](GlDevice device) { return std::make_unique<GlMarcher>(scene, bricks, device); });
  if (!gl && c.watched()) show_coarse(c, scene, bricks);
  Image image(look.width, look.height, frames, 1);
  Table table;
  table.columns = {"frame", "azimuth degrees", "rays", "samples", "texture lookups"};
  FrameCounts total;
  for (int i = 0; i < frames; ++i) {
    const double azimuth = look.azimuth + 360.0 * i / frames;
    FrameCounts counts;
    const Frame frame = frame_of(scene, azimuth);
    const Work work = c.work().part(0.2 + 0.8 * i / frames, 0.2 + 0.8 * (i + 1) / frames);
    const auto pixels = gl ? gl->march(frame, counts, work) : march(scene, frame, bricks, counts, work);
    std::copy(pixels.begin(), pixels.end(), image.pixels.begin() + image.index(0, 0, i));
    table.rows.push_back(
        {double(i), azimuth, double(counts.rays), double(counts.samples), double(counts.lookups)});
    total += counts;
  }
  c.metric("rays", total.rays);
  c.metric("samples", total.samples);
  c.metric("texture_lookups", total.lookups);
  c.output("image", std::move(image));
  c.output("table", std::move(table));
}

}  // namespace

namespace {

// What is drawn, from where.
void add_picture_parameters(NodeType& type) {
  type.parameter(
          Parameter::texts("classes",
                           {"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9 texture",
                            "muscle -30 150 #8f3a36 texture", "bone 150 4000 #efe6cf texture"})
              .count(1, 16)
              .doc_("Tissues: name, lower and upper density (Hounsfield units), then in any order a color, "
                    "`texture` or `noise`, and `opacity=…` (per step of a thousandth of the longest edge; "
                    "default: max(0.3, int + 0.25)) and `penetration=…` (mm, see there). Densities outside "
                    "all classes are transparent."))
      .parameter(Parameter::text("grid", "")
                     .doc_("Grid of the volume. Empty: the first grid with one number per voxel."))
      .parameter(Parameter::choice("mode", "textured", {"textured", "plain"})
                     .doc_("textured: each class with its texture. plain: each class in its texture's "
                           "mean color, for comparison."))
      .parameter(Parameter::choice("device", "cpu", {"cpu", "auto", "gl"})
                     .doc_("Where frames are rendered. cpu: identical bits on every machine. gl: OpenGL, "
                           "on a GPU or else by Mesa's software renderer. auto: a GPU if there is one, "
                           "else cpu. A warning names the device used. Rounding differs between devices, "
                           "so avoid auto if machines share a cache."))
      .parameter(
          Parameter::integer("width", 512).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
      .parameter(
          Parameter::integer("height", 512).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
      .parameter(Parameter::integer("samples", 1).range(1, 16).doc_("Rays per pixel along each of its edges"))
      .parameter(Parameter::number("step", 1).range(0.05, 4).unit_("voxels").doc_(
          "Distance between density samples along a ray, in shortest edges of a voxel. Density is linear "
          "between samples."))
      .parameter(Parameter::integer("frames", 1)
                     .range(1, 10000)
                     .doc_("Number of frames in one full turn around the axis `up`"))
      .parameter(
          Parameter::choice("up", "z", {"x", "y", "z"})
              .doc_("Axis of the volume that points up in the picture. The next axis points to azimuth 0."))
      .parameter(Parameter::number("azimuth", -41)
                     .unit_("degrees")
                     .range(-360, 360)
                     .doc_("Azimuth of the camera. In a scan with z up, 90 is the front."))
      .parameter(
          Parameter::number("elevation", 20).unit_("degrees").range(-85, 85).doc_("Elevation of the camera"))
      .parameter(Parameter::number("zoom", 1).range(0.1, 1000).doc_(
          "Magnification. 1 fits everything visible in the kept region, from every side."))
      .parameter(Parameter::numbers("clip", {0, 1, 0, 1, 0, 1})
                     .range(0, 1)
                     .count(6, 6)
                     .doc_("Region kept of x, y and z, from and to, as fractions of the edges. Cuts show "
                           "the inside."))
      .parameter(Parameter::numbers("scales", {10, 1, 0.1})
                     .range(1e-6, 1e6)
                     .count(3, 3)
                     .doc_("Factors on the textures' voxel size at the three scales, coarse to fine"))
      .parameter(Parameter::numbers("weights", {3, 1, 1})
                     .range(0, 1e6)
                     .count(3, 3)
                     .doc_("Weights of the three scales"))
      .parameter(Parameter::choice("turning", "random", {"random", "about_z", "none"})
                     .doc_("Rotation of each scale of each texture, so that repetitions do not line up. "
                           "random: any rotation. about_z: around z only, to keep grain along the "
                           "volume's z. none: no rotation."))
      .parameter(Parameter::numbers("window", {-1000, 1000})
                     .range(-1e9, 1e9)
                     .count(2, 2)
                     .doc_("Densities at which the method's `int`, which controls opacity and "
                           "brightness, is 0 and 1"));
}

// How tissues and light look.
void add_light_parameters(NodeType& type) {
  type.parameter(Parameter::number("modulation", 1)
                     .range(0, 100)
                     .doc_("Strength of brightening by density: 1 as in equation 7, 0 for none. Classes with "
                           "`noise` are exempt, as skin is in the paper."))
      .parameter(Parameter::number("opacity", 1)
                     .range(0, 1000)
                     .doc_("Factor on the opacity of all classes. With 0.1, light travels ten times as far."))
      .parameter(Parameter::number("translucency", 0)
                     .range(0, 1)
                     .doc_("Share of the lamp's light that enters the tissues. It falls off with the "
                           "distance that it travels through them and is scattered once, so that thin "
                           "parts shine and thick ones cast shadows. The rest lights surfaces. 0: surfaces "
                           "only, without shadows. Device cpu only."))
      .parameter(Parameter::number("penetration", 4)
                     .range(1e-9, 1e9)
                     .unit_("mm")
                     .doc_("Distance within tissue over which that light falls to 1/e, for classes "
                           "without a penetration of their own"))
      .parameter(Parameter::numbers("lamp", {-0.45, 0.55, 0.75})
                     .range(-1e6, 1e6)
                     .count(3, 3)
                     .doc_("Direction of the lamp in the picture: right, up, towards the viewer. A "
                           "negative last number puts it behind the scan."))
      .parameter(Parameter::number("ambient", 0.38)
                     .range(0, 1)
                     .doc_("Brightness of the light from all sides on surfaces and in translucent tissues. "
                           "The lamp adds up to 0.67."))
      .parameter(Parameter::number("skin_noise", 0.15)
                     .range(0, 1)
                     .doc_("Brightness variation of classes with `noise`"))
      .parameter(
          Parameter::number("skin_scale", 3).range(1e-9, 1e9).unit_("mm").doc_("Cell width of the noise"))
      .parameter(Parameter::color("background", 0.8, 0.8, 0.8).doc_("Background color"))
      .parameter(Parameter::seed());
}

}  // namespace

NodeType render_volume_node() {
  NodeType type =
      NodeType("RenderVolume", 3)
          .doc_(
              "Renders a picture of a scan, or a turntable. Density ranges define tissues, each with a solid "
              "texture at three scales.")
          .source_("Laursen, Ersbøll, Bærentzen 2011, sections 6 and 7")
          .input("volume", "Volume",
                 "Scan: a grid with one number per voxel, for example from LoadVolume or Phantom")
          .input_list("textures", {"Volume"},
                      "Solid textures (grid `Cd`), one for each class with the word `texture`, in the order "
                      "of their ranges. Without textures, every class shows its color.")
          .output("image", "Image", "Picture with one section per frame, scene-linear; 1 is white")
          .output("table", "Table",
                  "Cost of each frame: rays that hit the volume, density samples and texture lookups");
  add_picture_parameters(type);
  add_light_parameters(type);
  type.check_(check).compute_(compute);
  for (Port& p : type.inputs) p.optional |= p.many;
  return type;
}

}  // namespace terrazzo
