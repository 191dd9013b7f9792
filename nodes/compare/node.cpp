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

const std::vector<std::string> all_measures = {"size_classes", "area_fraction", "color"};

// What can be measured of a type of value.
std::vector<std::string> measures_of(const std::string& type) {
  if (type == "Profiles") return all_measures;
  if (type == "SizeDistribution") return {"size_classes"};
  return {"color"};
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
  measures.choices = all_measures;
  NodeType type("Compare", 1);
  type.doc_(
          "Compares two sets of profiles, two size distributions or two pictures, and tells which "
          "differences exceed sampling noise.")
      .source_(
          "Noise of counts: Poisson; of area fractions: a Boolean model's profiles (Underwood 1970; Ohser "
          "and Mücklich 2000).")
      .optional_input("a", {"Profiles", "SizeDistribution", "Image"}, "the reference")
      .optional_input("b", {"Profiles", "SizeDistribution", "Image"}, "what is compared with it, of the same type")
      .output("table", "Table",
              "measure, item, unit, lower and upper edge of a bin, a, b, difference b − a, tolerance, "
              "exceeds (0 or 1)")
      .output("figure", "Image", "bars of both by class, area fractions, mean colours")
      .parameter(measures.doc_(
          "Which of size_classes, area_fraction, color; all: those that apply to the inputs' type."))
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
