#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "graph/node_type.h"
#include "nodes/compare/comparison.h"
#include "runtime/context.h"

namespace terrazzo {

namespace {

const std::vector<std::string> of_profiles = {"size_classes", "area_fraction", "color", "circularity",
                                              "total_curvature"};
const std::vector<std::string> of_images = {"color", "bands", "patches", "two_point", "lineal_path", "seam"};

// What can be measured of a type of value.
std::vector<std::string> measures_of(const std::string& type) {
  if (type == "Profiles") return of_profiles;
  if (type == "SizeDistribution") return {"size_classes"};
  return of_images;
}

CompareChoice choice_of(const Context& c, const std::string& type) {
  std::vector<std::string> wanted = measures_of(type);
  if (c.keyword("measures").empty()) {
    const std::vector<std::string> possible = wanted;
    wanted = c.texts("measures");
    for (const auto& m : wanted)
      if (std::find(possible.begin(), possible.end(), m) == possible.end())
        throw Error("no-such-measure",
                    fmt::format("{} cannot be compared between values of type {}", m, type),
                    fmt::format("they can be compared by {}", fmt::join(possible, ", ")))
            .parameter("measures");
  }
  auto has = [&](const char* m) { return std::find(wanted.begin(), wanted.end(), m) != wanted.end(); };
  CompareChoice choice;
  choice.size_classes = has("size_classes"), choice.area_fraction = has("area_fraction"),
  choice.color = has("color");
  choice.circularity = has("circularity"), choice.total_curvature = has("total_curvature");
  choice.bands = has("bands"), choice.patches = has("patches"), choice.two_point = has("two_point");
  choice.lineal_path = has("lineal_path"), choice.seam = has("seam");
  choice.classes = static_cast<int>(c.integer("classes"));
  if (c.keyword("smallest").empty()) choice.smallest = c.number("smallest");
  return choice;
}

// The larger of both sets' smallest profiles: below it one of them may have been blind.
double both_show(const Profiles& a, const Profiles& b) {
  const auto smallest = [](const Profiles& p) {
    double area = std::numeric_limits<double>::infinity();
    for (const auto& q : p.profiles)
      if (q.weight > 0) area = std::min(area, q.area);
    return std::isfinite(area) ? std::sqrt(4 * area / std::numbers::pi) : 0;
  };
  return std::max(smallest(a), smallest(b)) * (1 - 1e-9);
}

void compute(Context& c) {
  const std::string type = c.value("a").type().name, other = c.value("b").type().name;
  if (type != other)
    throw Error("different-types", fmt::format("a is of type {}, b of type {}", type, other),
                "connect two values of one type");
  CompareChoice choice = choice_of(c, type);
  if (type == "Profiles" && !c.keyword("smallest").empty())
    choice.smallest = both_show(c.input<Profiles>("a"), c.input<Profiles>("b"));
  Comparison comparison;
  if (type == "Profiles")
    comparison = compare(c.input<Profiles>("a"), c.input<Profiles>("b"), choice);
  else if (type == "SizeDistribution")
    comparison = compare(c.input<SizeDistribution>("a"), c.input<SizeDistribution>("b"), choice);
  else
    comparison = compare(c.input<Image>("a"), c.input<Image>("b"), choice, c.work());
  for (const auto& w : comparison.warnings) c.warn(w);
  if (c.keyword("measures").empty() && comparison.warnings.empty())
    for (const auto& m : c.texts("measures"))
      if (std::none_of(comparison.numbers.begin(), comparison.numbers.end(),
                       [&](const auto& n) { return n.measure == m; }))
        c.warn(fmt::format("{} is not compared: a or b does not have what it takes, such as outlines", m));
  double exceeding = 0;
  for (const auto& n : comparison.numbers) exceeding += n.exceeds();
  comparison.metrics["exceeding"] = exceeding;
  for (const auto& [name, value] : comparison.metrics) c.metric(name, value);
  const auto names = c.texts("names");
  c.output("table", table_of(comparison));
  c.output("figure", figure_of(comparison, names[0], names[1]));
}

}  // namespace

NodeType compare_node() {
  Parameter measures = Parameter::with_keyword(ParameterKind::Texts, "measures", "all");
  measures.choices = of_profiles;
  measures.choices.insert(measures.choices.end(), of_images.begin() + 1, of_images.end());
  NodeType type("Compare", 2);
  type.doc_(
          "Compares two sets of profiles, two size distributions or two pictures, and tells which "
          "differences exceed sampling noise.")
      .source_(
          "Noise of counts: Poisson; of area fractions: a Boolean model's profiles (Underwood 1970; Ohser "
          "and Mücklich 2000).")
      .optional_input("a", {"Profiles", "SizeDistribution", "Image"}, "the reference")
      .optional_input("b", {"Profiles", "SizeDistribution", "Image"},
                      "what is compared with it, of the same type")
      .output("table", "Table",
              "measure, item, unit, lower and upper edge of a bin, a, b, difference b − a, tolerance, "
              "exceeds (0 or 1)")
      .output("figure", "Image",
              "bars of both by class, area fractions, mean colours, and what else is compared as curves")
      .parameter(measures.doc_(
          "Of profiles size_classes, area_fraction, color, circularity and total_curvature; of distributions "
          "size_classes; of pictures color and, as textures, bands, patches, two_point, lineal_path and "
          "seam; "
          "all: those that apply"))
      .parameter(Parameter::integer("classes", 10)
                     .range(1, 1000)
                     .doc_("Equal classes of √A up to the larger of both largest profiles; of distributions "
                           "only where their own differ."))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "smallest", "auto")
                     .unit_("mm")
                     .range(0, 1e9)
                     .doc_("Profiles of a smaller diameter √(4A/π) are left out of the size classes of both, "
                           "as a photograph may not show them; auto: the larger of both sets' smallest."))
      .parameter(Parameter::texts("names", {"a", "b"}).count(2, 2).doc_("What the figure calls the two."))
      .compute_(compute);
  for (auto& port : type.inputs) port.optional = false;
  return type;
}

}  // namespace terrazzo
