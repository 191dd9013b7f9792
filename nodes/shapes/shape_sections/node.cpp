#include <fmt/format.h>

#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape_sections/sections.h"
#include "nodes/shapes/shape_sections/views.h"
#include "runtime/context.h"

namespace terrazzo::shape_sections {
namespace {

enum class Planes { Random, Central, Principal };

void compute(Context& c) {
  const auto& shapes = c.input<Shapes>("shapes");
  if (shapes.shapes.empty())
    throw Error("no-shapes", "there are no shapes to cut", "connect at least one shape");
  for (const Shape& s : shapes.shapes)
    if (const auto faults = mesh_faults(s.mesh); !faults.empty())
      throw Error("open-mesh", fmt::format("the shape '{}' is not watertight: {}", s.name, faults[0]));
  const auto planes = c.choice<Planes>("planes");
  const std::size_t count = c.integer("count");
  const auto seed = c.seed();
  std::vector<BodySection> sections;
  if (planes == Planes::Principal) {
    sections = principal_sections(shapes);
  } else {
    const SectionKind kind = planes == Planes::Central ? SectionKind::Central : SectionKind::Random;
    sections = random_sections(shapes, count, {kind, seed, 0}, c.work().part(0, 0.7));
  }
  const double extent = largest_extent(sections);
  if (!(extent > 0)) throw Error("no-section", "no section of the shapes has an area", "check the shapes");
  const int columns = c.keyword("columns").empty()
                          ? static_cast<int>(c.integer("columns"))
                          : round_up(std::sqrt(static_cast<double>(sections.size())));
  const int cell = c.integer("cell");
  constexpr double kMost = 64e6;
  const double pixels =
      static_cast<double>(cell) * cell * columns * std::ceil(static_cast<double>(sections.size()) / columns);
  Profiles profiles = profiles_of(sections, columns, 1.15 * extent);
  c.metric("profiles", profiles.profiles.size());
  c.metric("sections", sections.size());
  // An image of all sections could be too large: show only the first rows.
  if (pixels > kMost) {
    const auto rows = std::max<std::size_t>(
        1, static_cast<std::size_t>(kMost / (static_cast<double>(cell) * cell * columns)));
    const std::size_t shown = std::min(sections.size(), rows * columns);
    c.warn(fmt::format("the image shows only the first {} of {} sections", shown, sections.size()));
    sections.resize(shown);
  }
  c.output("image", picture_of(sections, columns, cell, cell / (1.15 * extent), c.work().part(0.7, 1)));
  c.output("profiles", std::move(profiles));
  // Show only the first shapes of a large set, to keep the image viewable.
  constexpr std::size_t kShown = 64;
  Shapes shown = shapes;
  if (shown.shapes.size() > kShown) shown.shapes.resize(kShown);
  c.output("views", views_of(shown, cell, c.work()));
}

}  // namespace
}  // namespace terrazzo::shape_sections

namespace terrazzo {

NodeType shape_sections_node() {
  using namespace shape_sections;
  return NodeType("ShapeSections", 2)
      .doc_(
          "Computes exact plane sections of single shapes: their profiles, and an image of them side by "
          "side, black on white at one scale.")
      .source_("Jagnow, Dorsey, Rushmeier 2008, section 4 and figure 12")
      .input("shapes", "Shapes", "Shapes to cut; several are drawn by probability")
      .output("profiles", "Profiles",
              "One profile per connected region, with its outer contour. Areas exclude holes. Positions are "
              "those in the image.")
      .output("image", "Image", "The sections on a grid")
      .output("views", "Image",
              "Views of each shape (up to the first 64) from three sides, along its principal axes")
      .parameter(
          Parameter::choice("planes", "random", {"random", "central", "principal"})
              .doc_("random: uniformly distributed planes that meet a shape, as on a polished face. central: "
                    "planes through the centroid with uniformly distributed directions. principal: the three "
                    "planes perpendicular to each shape's principal axes; ignores `count`."))
      .parameter(
          Parameter::integer("count", 16).range(1, 1000000).doc_("Number of random or central sections"))
      .parameter(Parameter::seed().doc_("Random seed of the planes"))
      .parameter(Parameter::optional_integer("columns", "auto")
                     .range(1, 1000)
                     .doc_("Number of sections per row of the image. auto: about as many as there are rows."))
      .parameter(Parameter::integer("cell", 96)
                     .unit_("pixels")
                     .range(16, 1024)
                     .doc_("Edge length of the cell of a section in the image"))
      .compute_(compute);
}

}  // namespace terrazzo
