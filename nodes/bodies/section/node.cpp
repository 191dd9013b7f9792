#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/bodies/cutting/cut.h"
#include "nodes/bodies/cutting/section.h"
#include "nodes/bodies/cutting/volume_section.h"
#include "nodes/data/detail.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/context.h"

namespace terrazzo::section {
namespace {

SectionOptions choice_of(const NodeParameters& c) {
  SectionOptions choice;
  choice.planes = c.integer("planes");
  choice.axis = c.text("axis");
  if (c.keyword("offsets").empty()) choice.offsets = c.numbers("offsets");
  choice.width = c.optional_number("width").value_or(0);
  choice.height = c.optional_number("height").value_or(0);
  choice.pixel_size = c.optional_number("pixel_size").value_or(0);
  choice.seed = c.seed();
  const auto point = [&](const char* name) {
    const std::vector<double> v = c.numbers(name);
    if (v.size() != 3)
      throw Error("bad-value", fmt::format("{} has {} numbers, but needs three: x, y, z", name, v.size()))
          .parameter(name);
    return Vec3(v[0], v[1], v[2]);
  };
  if (choice.axis == "free") {
    choice.normal = point("normal");
    if (c.keyword("through").empty()) choice.through = point("through");
    if (choice.planes != 1)
      throw Error("planes-and-offsets",
                  fmt::format("planes is {}, but there is one free plane", choice.planes),
                  "leave planes at 1, or set axis to random")
          .parameter("planes");
  }
  const bool window = choice.axis == "random" || choice.axis == "free";
  if (!window && (choice.width > 0 || choice.height > 0))
    throw Error("window-on-axis",
                "width and height apply only to free and random planes; planes across an axis show a whole "
                "face of the "
                "box",
                "set axis to free or random, or set width and height to auto")
        .parameter(choice.width > 0 ? "width" : "height");
  if (choice.offsets.size() == 1 && choice.planes > 1)
    throw Error("planes-and-offsets", fmt::format("planes is {}, but there is one offset", choice.planes),
                "set one offset per plane, or leave planes at 1")
        .parameter("planes");
  return choice;
}

void check(const NodeParameters& p) { choice_of(p); }

// Takes the extent and the pixel size of the picture at input like, where the parameters leave them open.
SectionOptions with_picture(Context& c, SectionOptions choice) {
  const Image* like = c.optional<Image>("like");
  if (!like) return choice;
  constexpr int kMost = 1024;
  if (!(choice.pixel_size > 0)) choice.pixel_size = like->pixel_size;
  if (choice.axis == "random" || choice.axis == "free") {
    if (!(choice.width > 0)) choice.width = std::min(like->width, kMost) * like->pixel_size;
    if (!(choice.height > 0)) choice.height = std::min(like->height, kMost) * like->pixel_size;
  }
  return choice;
}

// Whether the pixels lie on the lattice of the detail's voxels, which then are shown as they are.
bool on_lattice(const SectionLayout& layout, double voxel) {
  bool axes = true;
  for (const SectionPlane& plane : layout.planes)
    axes = axes && plane.frame.cwiseAbs().colwise().maxCoeff().minCoeff() > 1 - 1e-9;
  return axes && std::abs(layout.width / layout.pixels_x / voxel - 1) < 1e-6 &&
         std::abs(layout.height / layout.pixels_y / voxel - 1) < 1e-6;
}

Section section_of_particles(Context& c) {
  const Particles* particles = c.optional<Particles>("particles");
  const Shapes* shapes = c.optional<Shapes>("shapes");
  if (!particles || !shapes)
    throw Error("missing-input",
                particles ? "particles are connected without their shapes"
                : shapes  ? "shapes are connected without particles"
                          : "nothing is connected",
                "connect particles and shapes, or a volume");
  check_particles(*particles, *shapes);
  const SectionLayout layout =
      choose_planes(with_picture(c, choice_of(c)), particles->box, true, particles->box.maxCoeff() / 512);
  std::optional<residual::ResidualField> detail;
  const Detail* given = c.optional<Detail>("detail");
  if (given)
    detail.emplace(*given, *particles, layout.pixel_size,
                   on_lattice(layout, given->pixel_size) ? residual::Keep::Values : residual::Keep::Power,
                   c.work().part(0, 0.1));
  Section section =
      cut_section(*particles, *shapes, layout, c.work().part(0.1, 1), detail ? &*detail : nullptr,
                  given ? residual::camera_of(*given, c.seed()) : residual::Camera{}, [&](const Image& flat) {
                    if (c.watched()) c.preview("image", flat);
                  });
  if (section.overlap > 1e-4)
    c.warn(fmt::format(
        "particles overlap in a share of {:.2g} of the sections' area, which area_fraction counts once",
        section.overlap));
  c.metric("overlap_fraction", section.overlap);
  return section;
}

// `colors_alone`: the volume has no grid to derive profiles from, as is the case for solid textures.
Section section_of_volume(Context& c, bool& colors_alone) {
  if (c.has("particles") || c.has("shapes"))
    throw Error("two-sources", "both particles and a volume are connected", "connect only one of them");
  const Volume& volume = *c.optional<Volume>("volume");
  const VolumeBox box = volume_box(volume);
  VolumeSection section = cut_volume(
      volume, choose_planes(with_picture(c, choice_of(c)), box.size, box.periodic, box.voxel), c.work());
  colors_alone = section.label_grid.empty();
  if (section.label_grid == "density")
    c.warn("the volume has no grid id: touching particles form one profile");
  return section;
}

void compute(Context& c) {
  bool colors_alone = false;
  Section section = c.has("volume") ? section_of_volume(c, colors_alone) : section_of_particles(c);
  const Profiles& profiles = section.profiles;
  if (!colors_alone) {
    double weights = 0;
    for (const Profile& p : profiles.profiles) weights += p.weight;
    c.metric("profiles", profiles.profiles.size());
    c.metric("area_fraction", profiles.area_fraction);
    c.metric("profiles_per_area", weights / profiles.observed_area);
    if (profiles.profiles.empty()) c.warn("the planes hit no particle");
  }
  c.output("image", std::move(section.image));
  c.output("labels", std::move(section.labels));
  c.output("profiles", std::move(section.profiles));
  c.output("table", std::move(section.table));
}

}  // namespace
}  // namespace terrazzo::section

namespace terrazzo {

NodeType section_node() {
  using namespace section;
  return NodeType("Section", 9)
      .doc_(
          "Cuts a packing or a volume with planes into an image, labels and profiles. Planes across an axis "
          "show one whole period. Random planes are isotropic and uniform, as stereology requires.")
      .source_(
          "Border weights: Miles 1974, Lantuéjoul 1978. Identities: Jagnow et al. 2004, eq. 1; Underwood "
          "1970.")
      .optional_input("particles", {"Particles"}, "Packing in a periodic box. Requires shapes")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input(
          "volume", {"Volume"},
          "Volume to cut instead of particles. Uses grid Cd or density, and id or phase for the labels")
      .optional_input("detail", {"Detail"},
                      "Fine detail from DetailSolid, added to the colors of particles and "
                      "binder. Not used for volumes, whose colors contain it")
      .optional_input("like", {"Image"},
                      "Picture that sets the pixel size of the sections and, for free and random planes, "
                      "their width and height, up to 1,024 pixels. Parameters that are set take precedence.")
      .output("image", "Image", "Stack of all sections, particles antialiased over the binder")
      .output("labels", "Labels", "Profile at each pixel's center; 0 is binder")
      .output("profiles", "Profiles",
              "One profile per connected region, exact for particles and counted in pixels for volumes. "
              "Empty for volumes that hold only colors")
      .output("table", "Table",
              "One row per profile: section, particle, class, area, weight; for particles also perimeter and "
              "holes")
      .parameter(Parameter::integer("planes", 1)
                     .range(1, 100000)
                     .doc_("Number of planes. If offsets are given, their count applies."))
      .parameter(
          Parameter::choice("axis", "z", {"x", "y", "z", "free", "random"})
              .doc_("Axis perpendicular to the planes. x shows y to the right and z up, y shows x and z, z "
                    "shows x and y. free: one plane, by normal and through. random: random orientation and "
                    "position."))
      .parameter(
          Parameter::numbers("normal", {0, 0, 1}).range(-1e9, 1e9).doc_("Normal of a free plane: x, y, z."))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "through", "auto")
                     .unit_("mm")
                     .range(-1e9, 1e9)
                     .doc_("Center of a free plane's window: x, y, z. auto: the box's center."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Numbers, "offsets", "auto")
              .unit_("mm")
              .range(0, 1e9)
              .doc_("Positions of the planes along the axis, from the box's corner. auto: evenly spaced, "
                    "half a step from both ends."))
      .parameter(Parameter::optional_number("width", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Window width of free and random planes. auto: the box's shortest edge."))
      .parameter(Parameter::optional_number("height", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Window height of free and random planes. auto: the box's shortest edge."))
      .parameter(
          Parameter::optional_number("pixel_size", "auto")
              .unit_("mm")
              .range(1e-9, 1e9)
              .doc_("Edge of a pixel, rounded so that whole pixels fill the width. auto: the box's longest "
                    "edge / 512, or a volume's voxel, and coarser if the stack would exceed 64 megapixels."))
      .parameter(
          Parameter::seed().doc_("Random seed of the planes' positions and orientations, and of noise."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
