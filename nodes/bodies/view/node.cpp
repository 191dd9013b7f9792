#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "graph/node_type.h"
#include "nodes/bodies/cutting/cut.h"
#include "nodes/bodies/cutting/section.h"
#include "nodes/bodies/view/surface_view.h"
#include "nodes/data/detail.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/context.h"

namespace terrazzo::view {
namespace {

View resolved_view(const Context& c, const Profiles* photograph) {
  for (const View view : kViews)
    if (c.text("view") == name_of(view)) return view;
  return photograph ? photograph->view : View::Section;
}

// Of the softness that was measured across outlines. The rest is that of outlines which lie beside the edge.
constexpr double kOfTheCamera = 0.4;
// Pixels: no lens and no color filter array shows outlines sharper than this standard deviation.
constexpr double kSharpest = 0.45;

// Random planes, whose size and pixels are those of pictures from above too.
section::SectionLayout layout_of(Context& c, const Vec3& box) {
  constexpr int kMost = 1024;
  section::SectionOptions choice;
  choice.planes = c.integer("pictures");
  choice.axis = "random";
  choice.width = c.optional_number("width").value_or(0);
  choice.height = c.optional_number("height").value_or(0);
  choice.pixel_size = c.optional_number("pixel_size").value_or(0);
  choice.seed = c.seed();
  if (const Image* like = c.optional<Image>("like")) {
    if (!(choice.pixel_size > 0)) choice.pixel_size = like->pixel_size;
    if (!(choice.width > 0)) choice.width = std::min(like->width, kMost) * like->pixel_size;
    if (!(choice.height > 0)) choice.height = std::min(like->height, kMost) * like->pixel_size;
  }
  return section::choose_planes(choice, box, true, box.maxCoeff() / 512);
}

template <class Result>
void output_result(Context& c, Result result) {
  c.metric("area_fraction", result.profiles.area_fraction);
  c.metric("profiles", result.profiles.profiles.size());
  c.output("image", std::move(result.image));
  c.output("labels", std::move(result.labels));
  c.output("profiles", std::move(result.profiles));
  c.output("table", std::move(result.table));
}

void show_planes(Context& c, const section::SectionLayout& layout, View view,
                 const residual::ResidualField* field) {
  const Detail* given = c.optional<Detail>("detail");
  const residual::Camera camera = given ? residual::camera_of(*given, c.seed()) : residual::Camera{};
  section::Section result =
      section::cut_section(c.input<Particles>("particles"), c.input<Shapes>("shapes"), layout,
                           c.work().part(0.1, 1), field, camera, [&](const Image& flat) {
                             if (c.watched()) c.preview("image", flat);
                           });
  if (result.overlap > 1e-4)
    c.warn(fmt::format(
        "particles overlap in a share of {:.2g} of the sections' area, which area_fraction counts once",
        result.overlap));
  if (result.profiles.profiles.empty()) c.warn("the planes hit no particle");
  result.profiles.view = view;
  output_result(c, std::move(result));
}

// Mean of all channels over the photograph's stones; nothing without stones.
std::optional<float> mean_brightness(const Profiles& photograph) {
  double sum = 0, area = 0;
  for (const Profile& p : photograph.profiles) {
    sum += p.area * p.color.mean();
    area += p.area;
  }
  if (!(sum > 0)) return {};
  return static_cast<float>(sum / area);
}

SurfaceOptions surface_options(const Context& c, const section::SectionLayout& layout,
                               const Particles& particles, const Shapes& shapes, const Profiles* photograph) {
  SurfaceOptions options;
  options.places = choose_places(count_of(layout.planes), particles, shapes, c.seed());
  options.width = layout.width;
  options.height = layout.height;
  options.pixels_x = layout.pixels_x;
  options.pixels_y = layout.pixels_y;
  options.pixel_size = layout.pixel_size;
  if (photograph && photograph->area_fraction > 0)  // 0: unknown
    options.area_fraction = std::min(photograph->area_fraction, 1.0);
  options.loose = photograph && shows_loose_stones(*photograph);
  if (photograph) options.brightness = mean_brightness(*photograph);
  std::optional<Vec2> slope;
  if (photograph && photograph->view == View::Surface) slope = photograph->light;
  options.light = light_of(slope, c.optional_number("azimuth"), c.optional_number("elevation"));
  if (slope && slope->norm() > 0) options.slope = options.light.slope;  // from where the sun stands
  options.shaded = c.boolean("shaded");
  options.seed = c.seed();
  return options;
}

void show_stones(Context& c, const section::SectionLayout& layout, const Profiles* photograph,
                 const residual::ResidualField* field) {
  const auto& particles = c.input<Particles>("particles");
  const auto& shapes = c.input<Shapes>("shapes");
  SurfaceOptions options = surface_options(c, layout, particles, shapes, photograph);
  std::optional<residual::Skins> skins;
  if (const Detail* detail = c.optional<Detail>("detail")) {
    const double azimuth = options.light.azimuth * std::numbers::pi / 180;
    skins.emplace(*detail, particles, shapes, layout.pixel_size, Vec2(std::cos(azimuth), std::sin(azimuth)),
                  c.work().quiet());
    options.tones = detail->tones;
    options.softness = std::max(kSharpest, kOfTheCamera * detail->softness) * detail->pixel_size;
  }
  SurfaceView result =
      show_surface(particles, shapes, options, field, skins ? &*skins : nullptr, c.work().part(0.1, 1));
  const double covered = result.profiles.area_fraction;
  if (options.area_fraction && covered < *options.area_fraction - 0.01)
    c.warn(
        fmt::format("stones cover a share of {:.3f}, and {:.3f} in the photograph: the packing is too "
                    "loose",
                    covered, *options.area_fraction));
  c.metric("particles_shown", static_cast<double>(result.stones));
  output_result(c, std::move(result));
}

void compute(Context& c) {
  const auto& particles = c.input<Particles>("particles");
  section::check_particles(particles, c.input<Shapes>("shapes"));
  const Profiles* photograph = c.optional<Profiles>("profiles");
  const View view = resolved_view(c, photograph);
  c.metric("view_section", view == View::Section);
  c.metric("view_surface", view == View::Surface);
  c.metric("view_filling", view == View::Filling);
  const section::SectionLayout layout = layout_of(c, particles.box);
  std::optional<residual::ResidualField> field;
  if (const Detail* detail = c.optional<Detail>("detail")) {
    const auto use = [&](const Detail& shown) {
      field.emplace(shown, particles, layout.pixel_size, residual::Keep::Power, c.work().part(0, 0.1));
    };
    if (view == View::Surface)
      use(residual::without_light(*detail));
    else
      use(*detail);
  }
  const residual::ResidualField* shown = field ? &*field : nullptr;
  if (view == View::Surface)
    show_stones(c, layout, photograph, shown);
  else
    show_planes(c, layout, view, shown);
}

void declare_ports(NodeType& type) {
  type.input("particles", "Particles", "Packing in a periodic box")
      .input("shapes", "Shapes", "Shapes of the particles")
      .optional_input("detail", {"Detail"},
                      "Fine detail from DetailSolid, added to the colors of particles and binder")
      .optional_input(
          "like", {"Image"},
          "Picture that sets the pixel size and, up to 1,024 pixels, width and height. Parameters "
          "that are set take precedence.")
      .optional_input("profiles", {"Profiles"},
                      "Profiles of the photograph: which view it is, where its light comes from and what "
                      "share of it stones cover")
      .output("image", "Image", "Stack of all pictures")
      .output("labels", "Labels",
              "Profile at each pixel's center; 0 is binder, and pieces of stones below 12 pixels")
      .output("profiles", "Profiles",
              "One profile per connected region of a particle: exact in planes, counted in pixels from above")
      .output("table", "Table",
              "One row per profile: section, particle, class, area, perimeter and weight; in planes also "
              "holes, from above the area of the whole silhouette");
}

void declare_size(NodeType& type) {
  type.parameter(Parameter::integer("pictures", 1)
                     .range(1, 1000)
                     .doc_("Number of random planes, or of pictures from above at different heights"))
      .parameter(Parameter::optional_number("width", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Width of a picture. auto: that of like, or the box's shortest edge."))
      .parameter(Parameter::optional_number("height", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Height of a picture. auto: that of like, or the box's shortest edge."))
      .parameter(
          Parameter::optional_number("pixel_size", "auto")
              .unit_("mm")
              .range(1e-9, 1e9)
              .doc_("Edge of a pixel, rounded so that whole pixels fill the width. auto: that of like, "
                    "or the box's longest edge / 512, and coarser if the stack would exceed 64 "
                    "megapixels."));
}

}  // namespace
}  // namespace terrazzo::view

namespace terrazzo {

NodeType view_node() {
  using namespace view;
  NodeType type("View", 13);
  type.doc_(
          "Shows the material as its photograph does: a plane section, or stones seen from above. Compare it "
          "with the photograph.")
      .source_("Sun and sky: Lambert 1760; ambient occlusion: Zhukov, Iones and Kronin 1998");
  declare_ports(type);
  type.parameter(
      Parameter::choice("view", "auto", {"auto", "section", "surface", "filling"})
          .doc_("section, filling: random planes. surface: stones seen from above. auto: the view of the "
                "profiles, or section without profiles."));
  declare_size(type);
  return type
      .parameter(Parameter::optional_number("azimuth", "auto")
                     .unit_("degrees")
                     .range(-360, 360)
                     .doc_("Direction in the picture that light comes from, in view surface: 0 is right, 90 "
                           "is up. auto: that of the profiles' light, or 135 without it."))
      .parameter(Parameter::optional_number("elevation", "auto")
                     .unit_("degrees")
                     .range(1, 90)
                     .doc_("Height of the sun above the horizon, in view surface. auto: 60 in flat light, "
                           "down to 40 in strong light."))
      .parameter(Parameter::boolean("shaded", true)
                     .doc_("Whether light falls on the stones of view surface. false: flat colors at once, "
                           "for pictures of which only the profiles count."))
      .parameter(Parameter::seed().doc_("Random seed of the planes, of the pictures' places, and of noise"))
      .compute_(compute);
}

}  // namespace terrazzo
