#include <fmt/format.h>

#include <cmath>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/compare/texture_observer/figure.h"
#include "nodes/compare/texture_observer/observer.h"
#include "nodes/data/table.h"
#include "runtime/context.h"

namespace terrazzo::texture_observer {
namespace {

void check(const NodeParameters& p) {
  if (p.integer("crop") % 8)
    throw Error("bad-value", fmt::format("crop must be a multiple of 8; it is {}", p.integer("crop")),
                fmt::format("use {}", (p.integer("crop") + 4) / 8 * 8))
        .parameter("crop");
}

void check_scales(const Image& a, const Image& b) {
  if (a.pixels.empty() || b.pixels.empty()) return;  // reported later
  const double ratio = b.pixel_size / a.pixel_size;
  if (!(std::abs(ratio - 1) <= 0.02))
    throw Error("size-mismatch",
                fmt::format("a pixel of a is {:.6g} mm wide, a pixel of b {:.6g} mm; they may differ by 2 %",
                            a.pixel_size, b.pixel_size),
                "make a section with the photograph's pixel_size");
}

void warn(Context& c, const Verdict& v) {
  const auto percent = [](double x) { return 100 * x; };
  if (v.control.share > 0.5 + 3 * v.control.error)
    c.warn(
        fmt::format("control of '{}': it tells cells of a from other cells of a in {:.1f} ± {:.1f} % of the "
                    "crops, so part of its accuracy does not tell a from b; use more sections or a larger "
                    "picture",
                    v.observer, percent(v.control.share), percent(v.control.error)));
  if (v.accuracy.share < 0.5 - 3 * v.accuracy.error)
    c.warn(
        fmt::format("'{}' recognizes {:.1f} ± {:.1f} %, less than by chance: the halves of a picture differ "
                    "more than the pictures, or b repeats parts of a",
                    v.observer, percent(v.accuracy.share), percent(v.accuracy.error)));
}

void compute(Context& c) {
  const Image &a = c.input<Image>("a"), &b = c.input<Image>("b");
  check_scales(a, b);
  CropOptions choice;
  choice.crop = c.integer("crop");
  choice.scale = c.integer("scale");
  choice.crops = c.integer("crops");
  choice.seed = c.seed();
  const Halves halves_a = halves_of(a, "a", choice, c.work().part(0, 0.05)),
               halves_b = halves_of(b, "b", choice, c.work().part(0.05, 0.1));
  const auto verdicts = observe(halves_a, halves_b, choice.seed, c.work().part(0.1, 1));

  Table t;
  t.columns = {"observer", "accuracy %",    "standard error %", "control %", "control error %",
               "crops",    "control crops", "gives it away",    "alone %"};
  for (const Verdict& v : verdicts) {
    const GroupAccuracy* most = v.giveaway();
    t.rows.push_back({v.observer, 100 * v.accuracy.share, 100 * v.accuracy.error, 100 * v.control.share,
                      100 * v.control.error, static_cast<double>(v.accuracy.crops),
                      static_cast<double>(v.control.crops), most ? most->name : "nothing",
                      most ? Table::Cell(100 * most->accuracy.share) : Table::Cell(std::string())});
    c.metric("accuracy_" + v.observer, v.accuracy.share);
    c.metric("control_" + v.observer, v.control.share);
    warn(c, v);
  }
  const Verdict& best = verdicts[verdicts[1].accuracy.share > verdicts[0].accuracy.share];
  c.metric("accuracy", best.accuracy.share);
  c.metric("standard_error", best.accuracy.error);
  c.metric("control", best.control.share);
  c.metric("crops", best.accuracy.crops);
  const double error = 0.5 / std::sqrt(best.accuracy.crops);
  if (error > 0.06)
    c.warn(
        fmt::format("{} crops give a standard error of up to {:.0f} %; use larger pictures, stacks of "
                    "sections or a smaller crop",
                    best.accuracy.crops, 100 * error));
  const auto names = c.texts("names");
  c.output("table", std::move(t));
  c.output("figure", figure_of(verdicts, best, halves_a, halves_b, {names[0], names[1]}));
}

}  // namespace
}  // namespace terrazzo::texture_observer

namespace terrazzo {

NodeType texture_observer_node() {
  using namespace texture_observer;
  return NodeType("TextureObserver", 1)
      .doc_(
          "Simulates an observer: how accurately trained classifiers distinguish crops of one picture from "
          "crops of another. 50 % is chance.")
      .source_(
          "Ojala, Pietikäinen, Mäenpää 2002 (local binary patterns); Coates and Ng 2011 (random whitened "
          "patches as filters)")
      .input("a", "Image", "Reference, such as a photograph, or a stack of sections")
      .input("b", "Image", "Picture to distinguish from a, such as a section of the solid, at the same scale")
      .output(
          "table", "Table",
          "One row per observer: accuracy, standard error, accuracy of the control and its standard error "
          "in %, number of crops judged, most telling group of features, and accuracy with it alone in %")
      .output("figure", "Image",
              "Crops that were recognized or mistaken most confidently, and bars of the accuracies")
      .parameter(Parameter::integer("crop", 64)
                     .range(32, 1024)
                     .unit_("pixels")
                     .doc_("Edge of a crop after reduction, a multiple of 8. Larger crops show more but are "
                           "fewer."))
      .parameter(Parameter::integer("scale", 1)
                     .range(1, 256)
                     .doc_("Reduction before observation: scale × scale pixels are averaged in linear light, "
                           "as if seen from farther away"))
      .parameter(Parameter::integer("crops", 500)
                     .range(16, 100000)
                     .doc_("Number of crops to judge per picture; up to one cell of 2 × 2 crops more are "
                           "used. Larger pictures are sampled at random."))
      .parameter(Parameter::texts("names", {"a", "b"}).count(2, 2).doc_("Names of a and b in the figure"))
      .parameter(Parameter::seed())
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
