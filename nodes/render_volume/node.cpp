#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "nodes/render_volume/gl_march.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

using namespace render_volume;

Error bad(const char* parameter, const std::string& what, const std::string& hint) {
  return Error(std::string("bad-") + parameter, what, hint).parameter(parameter);
}

template <std::size_t N>
std::array<double, N> exactly(const Context& c, const char* name) {
  const auto v = c.numbers(name);
  if (v.size() != N)
    throw bad(name, fmt::format("{} numbers are given", v.size()), fmt::format("write {}", N));
  std::array<double, N> out{};
  std::copy(v.begin(), v.end(), out.begin());
  return out;
}

Look look_of(const Context& c) {
  Look l;
  l.width = static_cast<int>(c.integer("width")), l.height = static_cast<int>(c.integer("height"));
  l.samples = static_cast<int>(c.integer("samples")), l.step = c.number("step");
  l.textured = c.text("mode") == "textured";
  l.scales = exactly<kScales>(c, "scales"), l.weights = exactly<kScales>(c, "weights");
  if (!(l.weights[0] + l.weights[1] + l.weights[2] > 0))
    throw bad("weights", "all weights are 0", "give one of them weight");
  const std::string turning = c.text("turning");
  l.turning = turning == "random" ? Turning::Random : turning == "about_z" ? Turning::AboutZ : Turning::None;
  const auto window = exactly<2>(c, "window");
  l.window = Vec2(window[0], window[1]);
  if (!(window[1] > window[0]))
    throw bad("window", fmt::format("it goes from {} to {}", window[0], window[1]), "let it rise");
  l.modulation = c.number("modulation"), l.opacity = c.number("opacity");
  l.skin_noise = c.number("skin_noise"), l.skin_scale = c.number("skin_scale");
  const auto clip = exactly<6>(c, "clip");
  for (int k = 0; k < 3; ++k) {
    l.clip[0][k] = static_cast<float>(clip[2 * k]), l.clip[1][k] = static_cast<float>(clip[2 * k + 1]);
    if (!(l.clip[1][k] > l.clip[0][k]))
      throw bad("clip",
                fmt::format("from {} to {} nothing is left of {}", clip[2 * k], clip[2 * k + 1], "xyz"[k]),
                "write x from, to, y from, to, z from, to, as shares of the edges");
  }
  l.up = c.text("up")[0] - 'x';
  l.azimuth = c.number("azimuth"), l.elevation = c.number("elevation"), l.zoom = c.number("zoom");
  const auto b = c.numbers("background");
  l.background = Vec3f(float(b[0]), float(b[1]), float(b[2]));
  l.seed = static_cast<std::uint64_t>(c.integer("seed"));
  return l;
}

// What draws the frames: a GPU, Mesa's software renderer, or nothing, which means the CPU's own rays.
std::unique_ptr<GlMarcher> gl_marcher(Context& c, const Scene& scene, const Bricks& bricks) {
  const std::string device = c.text("device");
  if (device == "cpu") return nullptr;
  try {
    return std::make_unique<GlMarcher>(scene, bricks, GlDevice::Gpu);
  } catch (const Error& e) {
    if (device == "auto") {
      c.warn("rendered on the CPU: " + e.diagnostic().message);
      return nullptr;
    }
    if (e.diagnostic().code != "no-gl") throw;
  }
  return std::make_unique<GlMarcher>(scene, bricks, GlDevice::Cpu);
}

void compute(Context& c) {
  const Look look = look_of(c);
  std::vector<Tissue> tissues = parse_tissues(c.texts("classes"));
  ScanField scan = scan_field(c.input<Volume>("volume"), c.text("grid"), c.work().part(0, 0.1));
  std::vector<SolidTexture> textures;
  for (const Value& v : c.list("textures"))
    textures.push_back(SolidTexture::of(v.as<Volume>(), c.work().quiet()));
  const Scene scene(std::move(scan), std::move(tissues), std::move(textures), look);
  const Bricks bricks(scene.scan, scene.intervals, c.work().part(0.1, 0.2));
  if (bricks.visible_share() == 0) {
    const double high = scene.scan.low + 65535.0 * scene.scan.step;
    c.warn(fmt::format("no class holds any of the volume's densities, {:.6g} to {:.6g}: the picture is empty",
                       scene.scan.low, high));
  }
  c.metric("visible_bricks", bricks.visible_share());

  const int frames = static_cast<int>(c.integer("frames"));
  const auto gl = gl_marcher(c, scene, bricks);
  if (gl) c.warn("rendered by OpenGL on " + gl->renderer());
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
    std::copy(pixels.begin(), pixels.end(),
              image.pixels.begin() + static_cast<std::ptrdiff_t>(image.index(0, 0, i)));
    table.rows.push_back(
        {double(i), azimuth, double(counts.rays), double(counts.samples), double(counts.lookups)});
    total += counts;
  }
  c.metric("rays", static_cast<double>(total.rays));
  c.metric("samples", static_cast<double>(total.samples));
  c.metric("texture_lookups", static_cast<double>(total.lookups));
  c.output("image", std::move(image));
  c.output("table", std::move(table));
}

}  // namespace

NodeType render_volume_node() {
  NodeType type =
      NodeType("RenderVolume", 2)
          .doc_(
              "A picture of a scan, or of a turn about it: tissues by ranges of density, each in its solid "
              "texture at "
              "three scales")
          .source_("Laursen, Ersbøll, Bærentzen 2011, sections 6 and 7")
          .input("volume", "Volume",
                 "the scan: a grid of one number a voxel, such as LoadVolume's or Phantom's")
          .input_list(
              "textures", {"Volume"},
              "solid textures (grid `Cd`), one for each class with the word `texture`, in the order of their "
              "ranges; without any every class shows its colour")
          .output("image", "Image", "one section a frame, scene-linear; 1 is white")
          .output("table", "Table",
                  "what each frame took: rays that meet the volume, densities and textures looked up")
          .parameter(
              Parameter::texts("classes",
                               {"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9 texture",
                                "muscle -30 150 #8f3a36 texture", "bone 150 4000 #efe6cf texture"})
                  .count(1, 16)
                  .doc_(
                      "Tissues: name, lower and upper density (Hounsfield units), then in any order a "
                      "colour, "
                      "`texture` or `noise`, and `opacity=…` (of a step of a thousandth of the longest edge; "
                      "without it max(0.3, int + 0.25)). Densities of no class are clear"))
          .parameter(
              Parameter::text("grid", "").doc_("Of the volume; empty for the first of one number a voxel"))
          .parameter(Parameter::choice("mode", "textured", {"textured", "plain"})
                         .doc_("plain: each class in its texture's mean colour, for comparison"))
          .parameter(Parameter::choice("device", "cpu", {"cpu", "auto", "gl"})
                         .doc_("cpu: the same bits everywhere; gl: OpenGL, on a GPU, else by Mesa's software "
                               "renderer; "
                               "auto: a GPU where there is one, else cpu. A warning says which it was; who "
                               "shares a cache "
                               "between machines should not write auto, since rounding differs"))
          .parameter(
              Parameter::integer("width", 512).unit_("pixels").range(1, 16384).doc_("Width of the picture"))
          .parameter(
              Parameter::integer("height", 512).unit_("pixels").range(1, 16384).doc_("Height of the picture"))
          .parameter(
              Parameter::integer("samples", 1).range(1, 16).doc_("Rays a pixel, along each of its edges"))
          .parameter(Parameter::number("step", 1).range(0.05, 4).unit_("voxels").doc_(
              "Between densities along a ray, in shortest edges of a voxel; between two the density is "
              "taken as linear"))
          .parameter(
              Parameter::integer("frames", 1).range(1, 10000).doc_("Of one full turn about the axis `up`"))
          .parameter(
              Parameter::choice("up", "z", {"x", "y", "z"})
                  .doc_("The volume's axis that points up in the picture; the next one points to azimuth 0"))
          .parameter(Parameter::number("azimuth", -41)
                         .unit_("degrees")
                         .range(-360, 360)
                         .doc_("Where the viewer stands; in a scan with z up, 90 is the front"))
          .parameter(Parameter::number("elevation", 20)
                         .unit_("degrees")
                         .range(-85, 85)
                         .doc_("How high the viewer stands"))
          .parameter(Parameter::number("zoom", 1).range(0.1, 1000).doc_(
              "1 shows all that can be seen of what is kept, from every side"))
          .parameter(Parameter::numbers("clip", {0, 1, 0, 1, 0, 1})
                         .range(0, 1)
                         .count(6, 6)
                         .doc_("What is kept of x, y and z, from and to, as shares of the edges; cuts show "
                               "the inside"))
          .parameter(
              Parameter::numbers("scales", {10, 1, 0.1})
                  .above(0)
                  .count(3, 3)
                  .doc_("How much larger each texture is than its own voxel size says, coarse to fine"))
          .parameter(Parameter::numbers("weights", {3, 1, 1}).range(0, 1e6).count(3, 3).doc_("Of the scales"))
          .parameter(Parameter::choice("turning", "random", {"random", "about_z", "none"})
                         .doc_("How each scale of each texture is turned so that repetitions do not line up; "
                               "about_z keeps "
                               "grain along the volume's z"))
          .parameter(
              Parameter::numbers("window", {-1000, 1000})
                  .range(-1e9, 1e9)
                  .count(2, 2)
                  .doc_("Densities at which the method's `int`, on which opacity and brightness depend, "
                        "is 0 and 1"))
          .parameter(
              Parameter::number("modulation", 1)
                  .range(0, 100)
                  .doc_("How much brighter a class gets with density: 1 as in equation 7, 0 not at all"))
          .parameter(Parameter::number("opacity", 1)
                         .range(0, 1000)
                         .doc_("Of all classes: 0.1 lets ten times as much through"))
          .parameter(Parameter::number("skin_noise", 0.15)
                         .range(0, 1)
                         .doc_("Of classes with `noise`: how much their brightness varies"))
          .parameter(
              Parameter::number("skin_scale", 3).above(0).unit_("mm").doc_("Width of the noise's cells"))
          .parameter(Parameter::color("background", 0.8, 0.8, 0.8).doc_("Behind the volume"))
          .parameter(Parameter::integer("seed", 1)
                         .range(0, 9007199254740991)
                         .doc_("Of the textures' rotations and offsets, and of the noise"))
          .compute_(compute);
  for (Port& p : type.inputs) p.optional |= p.many;
  return type;
}

}  // namespace terrazzo
