#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "graph/node_type.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/data/equal_size.h"
#include "runtime/context.h"

namespace terrazzo::compare {
namespace {

const std::vector<std::string> of_profiles = {"size_classes",    "area_fraction", "color",      "circularity",
                                              "total_curvature", "two_point",     "lineal_path"};
const std::vector<std::string> of_images = {"color", "bands", "patches", "two_point", "lineal_path", "seam"};

// The measures available for a value type.
std::vector<std::string> measures_of(const std::string& type) {
  if (type == "Profiles") return of_profiles;
  if (type == "SizeDistribution") return {"size_classes"};
  return of_images;
}

CompareOptions choice_of(const Context& c, const std::string& type) {
  std::vector<std::string> wanted = measures_of(type);
  if (c.keyword("measures").empty()) {
    const std::vector<std::string> possible = wanted;
    wanted = c.texts("measures");
    for (const auto& m : wanted)
      if (std::find(possible.begin(), possible.end(), m) == possible.end())
        throw Error("no-such-measure", fmt::format("measure {} does not apply to values of type {}", m, type),
                    fmt::format("use {}", fmt::join(possible, ", ")))
            .parameter("measures");
  }
  auto has = [&](const char* m) { return std::find(wanted.begin(), wanted.end(), m) != wanted.end(); };
  CompareOptions choice;
  choice.size_classes = has("size_classes");
  choice.area_fraction = has("area_fraction");
  choice.color = has("color");
  choice.circularity = has("circularity");
  choice.total_curvature = has("total_curvature");
  choice.bands = has("bands");
  choice.patches = has("patches");
  choice.two_point = has("two_point");
  choice.lineal_path = has("lineal_path");
  choice.seam = has("seam");
  choice.classes = c.integer("classes");
  if (const auto v = c.optional_number("smallest")) choice.smallest = *v;
  return choice;
}

// The larger of both sets' smallest diameters. One set may not resolve profiles below it.
double both_show(const Profiles& a, const Profiles& b) {
  const auto smallest = [](const Profiles& p) {
    double area = std::numeric_limits<double>::infinity();
    for (const auto& q : p.profiles)
      if (q.weight > 0) area = std::min(area, q.area);
    return std::isfinite(area) ? std::sqrt(4 * area / std::numbers::pi) : 0;
  };
  return std::max(smallest(a), smallest(b)) * (1 - 1e-9);
}

// Labels with −1 where the mask is not 0.
Labels observed(const Context& c, Labels labels) {
  const auto* mask = c.optional<Labels>("mask_a");
  if (!mask) return labels;
  require_equal_size(*mask, "mask_a has", labels, "labels_a have", "use the mask of the same photograph");
  for (std::size_t i = 0; i < labels.ids.size(); ++i)
    if (mask->ids[i] != 0) labels.ids[i] = -1;
  return labels;
}

Comparison compare_sections(Context& c, const CompareOptions& choice) {
  Comparison out = compare::compare(c.input<Profiles>("a"), c.input<Profiles>("b"), choice);
  if (const auto* a = c.optional<Labels>("labels_a"))
    compare_phases(observed(c, *a), c.input<Labels>("labels_b"), choice, out, c.work());
  return out;
}

void compute(Context& c) {
  const std::string type = c.value("a").type().name, other = c.value("b").type().name;
  if (type != other)
    throw Error("different-types", fmt::format("a has type {}, but b has type {}", type, other),
                "connect two values of the same type");
  if (c.has("labels_a") != c.has("labels_b"))
    throw Error("missing-input", "one of labels_a and labels_b is connected, but not the other",
                "connect both, or none");
  if (c.has("labels_a") && type != "Profiles")
    throw Error("different-types",
                fmt::format("labels are compared along with Profiles, but a has type {}", type),
                "disconnect labels_a and labels_b");
  CompareOptions choice = choice_of(c, type);
  if (type == "Profiles" && !c.keyword("smallest").empty())
    choice.smallest = both_show(c.input<Profiles>("a"), c.input<Profiles>("b"));
  Comparison comparison;
  if (type == "Profiles")
    comparison = compare_sections(c, choice);
  else if (type == "SizeDistribution")
    comparison = compare::compare(c.input<SizeDistribution>("a"), c.input<SizeDistribution>("b"), choice);
  else
    comparison = compare::compare(c.input<Image>("a"), c.input<Image>("b"), choice, c.work());
  for (const auto& w : comparison.warnings) c.warn(w);
  if (c.keyword("measures").empty() && comparison.warnings.empty())
    for (const auto& m : c.texts("measures"))
      if (std::none_of(comparison.numbers.begin(), comparison.numbers.end(),
                       [&](const auto& n) { return n.measure == m; }))
        c.warn(
            fmt::format("{} is not compared: a or b lacks the data for it, such as outlines or labels", m));
  double exceeding = 0;
  for (const auto& n : comparison.numbers) exceeding += n.exceeds();
  comparison.metrics["exceeding"] = exceeding;
  for (const auto& [name, value] : comparison.metrics) c.metric(name, value);
  const auto names = c.texts("names");
  c.output("table", table_of(comparison));
  c.output("figure", figure_of(comparison, names[0], names[1]));
}

}  // namespace
}  // namespace terrazzo::compare

namespace terrazzo {

NodeType compare_node() {
  using namespace compare;
  Parameter measures = Parameter::with_keyword(ParameterKind::Texts, "measures", "all");
  measures.choices = of_profiles;
  for (const auto& m : of_images)
    if (std::find(of_profiles.begin(), of_profiles.end(), m) == of_profiles.end())
      measures.choices.push_back(m);
  NodeType type("Compare", 4);
  type.doc_(
          "Compares two sets of profiles, two size distributions or two images, and reports which "
          "differences exceed sampling noise.")
      .source_(
          "Noise of counts: Poisson. Noise of area fractions: Boolean model (Underwood 1970; Ohser and "
          "Mücklich 2000).")
      .optional_input("a", {"Profiles", "SizeDistribution", "Image"}, "Reference")
      .optional_input("b", {"Profiles", "SizeDistribution", "Image"},
                      "Value to compare with a, of the same type")
      .optional_input("labels_a", {"Labels"}, "Labels of a's profiles, to compare two_point and lineal_path")
      .optional_input("labels_b", {"Labels"}, "Labels of b's profiles")
      .optional_input(
          "mask_a", {"Labels"},
          "Not 0: pixels of labels_a that were not observed, such as output unobserved of Segment")
      .output("table", "Table",
              "One row per compared number: measure, item, unit, lower and upper bin edge, a, b, difference "
              "b − a, tolerance, exceeds (0 or 1)")
      .output("figure", "Image",
              "Bars of a and b by class, area fractions, mean colors, and curves of the other measures")
      .parameter(measures.doc_(
          "Measures to compare. Profiles: size_classes, area_fraction, color, circularity, total_curvature, "
          "and with labels two_point and lineal_path. Distributions: size_classes. Images: color and the "
          "texture measures bands, patches, two_point, lineal_path, seam. all: every measure that applies."))
      .parameter(
          Parameter::integer("classes", 10)
              .range(1, 1000)
              .doc_("Number of equal classes of √A up to the largest profile. For distributions, used only "
                    "if their class edges differ."))
      .parameter(Parameter::optional_number("smallest", "auto")
                     .unit_("mm")
                     .range(0, 1e9)
                     .doc_("Smallest profile diameter √(4A/π) in the size classes of both sets, since a "
                           "photograph may not resolve smaller ones. auto: the larger of both sets' smallest "
                           "diameters."))
      .parameter(Parameter::texts("names", {"a", "b"}).count(2, 2).doc_("Names of a and b in the figure."))
      .compute_(compute);
  for (auto& port : type.inputs)
    if (port.name == "a" || port.name == "b") port.optional = false;
  return type;
}

}  // namespace terrazzo
