#include <algorithm>
#include <cmath>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/profiles.h"
#include "runtime/context.h"

namespace terrazzo::palette {
namespace {

void check(const NodeParameters& p) {
  const auto colors = p.texts("colors");
  const std::size_t shares = p.numbers("shares").size();
  if (shares != 1 && shares != colors.size())
    throw Error("bad-shares", "there are " + std::to_string(colors.size()) + " colors but " +
                                  std::to_string(shares) + " shares")
        .parameter("shares");
  const std::size_t classes = p.ints("classes").size();
  if (classes != 1 && classes != colors.size())
    throw Error("bad-classes", "there are " + std::to_string(colors.size()) + " colors but " +
                                   std::to_string(classes) + " classes")
        .parameter("classes");
  for (const auto& color : colors) parse_color(color);
}

void compute(Context& c) {
  const auto colors = c.texts("colors");
  auto shares = c.numbers("shares");
  if (shares.size() == 1) shares.assign(colors.size(), 1.0);
  auto classes = c.ints("classes");
  if (classes.size() == 1) classes.assign(colors.size(), classes[0]);
  Profiles out;
  const auto binder = c.numbers("binder");
  out.binder_color =
      Vec3f(static_cast<float>(binder[0]), static_cast<float>(binder[1]), static_cast<float>(binder[2]));
  for (std::size_t i = 0; i < colors.size(); ++i) {
    Profile p;
    p.area = 1;
    p.weight = shares[i];
    p.color = parse_color(colors[i]);
    p.cls = classes[i];
    out.classes = std::max(out.classes, p.cls + 1);
    out.profiles.push_back(p);
  }
  c.output("profiles", std::move(out));
}

}  // namespace
}  // namespace terrazzo::palette

namespace terrazzo {

NodeType palette_node() {
  using namespace palette;
  return NodeType("Palette", 2)
      .doc_(
          "Defines particle and binder colors in the graph, in place of the colors of a photograph's "
          "profiles")
      .output("profiles", "Profiles",
              "One profile of 1 mm² per color, weighted by its share, without outlines or densities")
      .parameter(Parameter::texts("colors", {"#b0785a", "#3c3c40", "#d8d2c4"})
                     .count(1, 256)
                     .doc_("Particle colors, \"#rrggbb\" in sRGB"))
      .parameter(Parameter::numbers("shares", {1})
                     .range(1e-12, 1e12)
                     .count(1, 256)
                     .doc_("Relative frequency of each color. A single number makes all equal."))
      .parameter(Parameter::ints("classes", {0})
                     .range(0, 255)
                     .count(1, 256)
                     .doc_("Particle class of each color, for Colorize with mode: classes. A single number "
                           "makes all equal."))
      .parameter(Parameter::color("binder", 0.75, 0.72, 0.66).doc_("Binder color"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
