#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/properties/homogenize/conduction.h"
#include "nodes/properties/homogenize/flow.h"
#include "nodes/properties/homogenize/report.h"
#include "runtime/context.h"

namespace terrazzo::homogenize {
namespace {

// In the order of the parameters' words.
enum class Property { Conductivity, Stiffness, Permeability };
enum class Around { Automatic, Periodic, Fixed };

constexpr double kLargestContrast = 1e12;
constexpr int kLeastHalf = 4;  // voxels along an edge at half the resolution
const std::vector<std::string> kAxes = {"x", "y", "z"};
const std::vector<std::string> kVoigt = {"xx", "yy", "zz", "yz", "xz", "xy"};

// What was found at one resolution.
struct Result {
  Eigen::MatrixXd effective;  // 3 × 3, or 6 × 6 for stiffness
  std::array<bool, 3> connected{true, true, true};
  Convergence convergence;
  std::vector<float> flow, potential;
};

std::array<bool, 3> directions_of(const NodeParameters& p) {
  std::array<bool, 3> out{};
  for (const std::string& word : p.texts("directions")) {
    const auto at = std::find(kAxes.begin(), kAxes.end(), word);
    if (at == kAxes.end())
      throw Error("bad-value", fmt::format("'{}' is not a direction", word), "use x, y, z")
          .parameter("directions");
    out[at - kAxes.begin()] = true;
  }
  return out;
}

std::vector<Elastic> elastic_values(const NodeParameters& p) {
  const auto& numbers = p.numbers("values");
  std::vector<Elastic> out;
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) out.push_back({numbers[i], numbers[i + 1]});
  return out;
}

Error bad_values(const std::string& what, const std::string& hint) {
  return Error("bad-value", what, hint).parameter("values");
}

void check_elastic(const NodeParameters& p) {
  if (p.numbers("values").size() % 2 == 1)
    throw bad_values(fmt::format("{} numbers are not pairs", p.numbers("values").size()),
                     "give Young's modulus and Poisson's ratio of each phase");
  for (const Elastic& v : elastic_values(p)) {
    if (!(v.young >= 0))
      throw bad_values(fmt::format("Young's modulus {} is negative", v.young), "use 0 for pores");
    if (!(v.poisson > -1 && v.poisson < 0.5))
      throw bad_values(fmt::format("Poisson's ratio {} is not above −1 and below 0.5", v.poisson),
                       "give pairs of Young's modulus and Poisson's ratio");
  }
  if (p.choice<Around>("boundary") == Around::Fixed)
    throw Error("bad-value", "stiffness is found for periodic volumes only", "set boundary: periodic")
        .parameter("boundary");
}

void check(const NodeParameters& p) {
  directions_of(p);
  const auto& values = p.numbers("values");
  const auto property = p.choice<Property>("property");
  if (property == Property::Stiffness)
    check_elastic(p);
  else
    for (const double v : values) {
      if (v < 0)
        throw bad_values(fmt::format("the value {} is negative", v),
                         "use 0 for a phase that does not conduct");
      if (property == Property::Permeability && v != 0 && v != 1)
        throw bad_values(fmt::format("the value {} is neither 0 nor 1", v),
                         "for permeability use 1 for phases in which the fluid flows, and 0 for solid ones");
    }
  const std::size_t step = property == Property::Stiffness ? 2 : 1;
  double least = INFINITY, most = 0;
  for (std::size_t i = 0; i < values.size(); i += step) {
    most = std::max(most, values[i]);
    if (values[i] > 0) least = std::min(least, values[i]);
  }
  if (most > kLargestContrast * least)
    throw bad_values(fmt::format("the values {} and {} differ by more than a factor of {:.0e}", least, most,
                                 kLargestContrast),
                     "use 0 instead of the smaller one");
  if (!(most > 0)) throw bad_values("every phase has the value 0", "give at least one phase a value above 0");
}

void check_count(const PhaseMap& map, std::size_t count) {
  if (map.count() == count) return;
  std::vector<std::string> phases;
  for (std::size_t i = 0; i < map.count(); ++i)
    phases.push_back(fmt::format("{} with {:.3g} %", map.names[i], 100 * map.fraction[i]));
  throw bad_values(fmt::format("there are values for {} phases, but the volume has {}: {}", count,
                               map.count(), fmt::join(phases, ", ")),
                   "give a value for each phase, in this order");
}

bool periodic(const Context& c, const PhaseMap& map) {
  const auto around = c.choice<Around>("boundary");
  return around == Around::Periodic || (around == Around::Automatic && map.box.periodic);
}

Result solve_for(const Context& c, const PhaseMap& map, const Work& work) {
  const Accuracy accuracy{c.number("tolerance"), static_cast<int>(c.integer("iterations"))};
  Result out;
  const auto property = c.choice<Property>("property");
  if (property == Property::Stiffness) {
    SolvedStiffness s = stiffness(map, elastic_values(c), accuracy, c.memory(), work);
    out.effective = s.effective;
    out.convergence = {s.iterations, s.residual};
    out.flow = std::move(s.stress);
    return out;
  }
  const Boundary boundary = periodic(c, map) ? Boundary::Periodic : Boundary::Fixed;
  const auto& values = c.numbers("values");
  Solved s = property == Property::Conductivity
                 ? conduct(map, values, boundary, directions_of(c), accuracy, c.memory(), work)
                 : permeate(map, {values.begin(), values.end()}, boundary, directions_of(c), accuracy,
                            c.memory(), work);
  out.effective = s.effective;
  out.connected = s.connected;
  out.convergence = {s.iterations, s.residual};
  out.flow = std::move(s.flow);
  out.potential = std::move(s.potential);
  return out;
}

// Half the resolution, if edges have enough voxels. Stiffness needs cubes, but a single layer may have any
// thickness.
std::optional<PhaseMap> coarse_map(const PhaseMap& map, bool cubes, const Work& work) {
  for (int a = 0; a < 3; ++a)
    if (map.box.size[a] > 1 && map.box.size[a] < 2 * kLeastHalf) return {};
  if (map.box.count() == 1) return {};
  PhaseMap half = halved(map, work);
  Vec3& edge = half.box.spacing;
  for (int a = 0; cubes && a < 3; ++a)
    if (half.box.size[a] == 1) edge[a] = edge.maxCoeff();
  if (cubes && edge.maxCoeff() > 1.0001 * edge.minCoeff()) return {};
  return half;
}

// What was found at half the resolution, and in which phases.
struct Half {
  PhaseMap map;
  Result result;
};

std::optional<Half> half_of(Context& c, const PhaseMap& map, const Work& work) {
  const auto half = coarse_map(map, c.choice<Property>("property") == Property::Stiffness, work.quiet());
  if (!half) return {};
  try {
    return Half{*half, solve_for(c, *half, work)};
  } catch (const Error& e) {
    if (e.diagnostic().code != "not-converged") throw;
    c.warn("there is no voxel_error, because at half the resolution " + e.diagnostic().message);
    return {};
  }
}

// How much the result differs from that at half the resolution, relative to its largest value. If the error
// is proportional to the voxel's edge, this is the error (Richardson 1911).
std::optional<double> voxel_error(const Result& whole, const std::optional<Half>& half) {
  const double largest = whole.effective.cwiseAbs().maxCoeff();
  if (!half || !(largest > 0)) return {};
  return (whole.effective - half->result.effective).cwiseAbs().maxCoeff() / largest;
}

void add_scalar_measures(const Context& c, const PhaseMap& map, const Result& r, std::vector<Measure>& out) {
  const bool flow = c.choice<Property>("property") == Property::Permeability;
  const std::string unit = flow ? "mm²" : "";
  const auto directions = directions_of(c);
  const bool all = directions[0] && directions[1] && directions[2];
  for (int a = 0; a < 3; ++a)
    if (directions[a])
      out.push_back({"effective " + kVoigt[a], "effective_" + kVoigt[a], r.effective(a, a), unit});
  if (all && periodic(c, map))
    for (const auto& [k, i, j] : {std::tuple(3, 1, 2), std::tuple(4, 0, 2), std::tuple(5, 0, 1)})
      out.push_back({"effective " + kVoigt[k], "effective_" + kVoigt[k],
                     (r.effective(i, j) + r.effective(j, i)) / 2, unit});
  if (all) out.push_back({"effective, mean", "effective_mean", r.effective.trace() / 3, unit});
  if (flow) return;
  const Bounds wiener = wiener_bounds(map.fraction, c.numbers("values"));
  for (int a = 0; a < 3; ++a)
    if (directions[a] && r.connected[a])
      out.push_back(
          {"tortuosity " + kAxes[a], "tortuosity_" + kAxes[a], wiener.high / r.effective(a, a), ""});
  out.push_back({"lower bound", "", wiener.low, ""});
  out.push_back({"upper bound", "", wiener.high, ""});
  if (map.box.size.minCoeff() == 1) return;  // what is isotropic in a plane has other bounds
  const Bounds isotropic = hashin_shtrikman(map.fraction, c.numbers("values"));
  out.push_back({"lower bound if isotropic", "", isotropic.low, ""});
  out.push_back({"upper bound if isotropic", "", isotropic.high, ""});
}

void add_elastic_measures(const Context& c, const PhaseMap& map, const Result& r, std::vector<Measure>& out) {
  for (int i = 0; i < 6; ++i)
    out.push_back({"effective " + kVoigt[i], "effective_" + kVoigt[i], r.effective(i, i), ""});
  const Moduli m = isotropic_part(r.effective);
  out.push_back({"Young's modulus", "young", m.young(), ""});
  out.push_back({"Poisson's ratio", "poisson", m.poisson(), ""});
  out.push_back({"bulk modulus", "bulk", m.bulk, ""});
  out.push_back({"shear modulus", "shear", m.shear, ""});
  const ElasticBounds bounds = hashin_shtrikman(map.fraction, elastic_values(c));
  out.push_back({"lower bound of the bulk modulus", "", bounds.bulk.low, ""});
  out.push_back({"upper bound of the bulk modulus", "", bounds.bulk.high, ""});
  out.push_back({"lower bound of the shear modulus", "", bounds.shear.low, ""});
  out.push_back({"upper bound of the shear modulus", "", bounds.shear.high, ""});
}

std::vector<Measure> measures_of(const Context& c, const PhaseMap& map, const Result& r) {
  std::vector<Measure> out;
  if (c.choice<Property>("property") == Property::Stiffness)
    add_elastic_measures(c, map, r, out);
  else
    add_scalar_measures(c, map, r, out);
  for (std::size_t i = 0; i < map.count(); ++i)
    out.push_back({"fraction of " + map.names[i], "", map.fraction[i], ""});
  return out;
}

Shown shown_of(const Context& c, const PhaseMap& map, const Result& r) {
  Shown out;
  out.field = &r.flow;
  const auto property = c.choice<Property>("property");
  if (property == Property::Stiffness) {
    const Moduli m = isotropic_part(r.effective);
    out.title = "Bulk and shear modulus";
    out.value_label = "modulus";
    out.names = {"bulk", "lower", "upper", "shear", "lower", "upper"};
    const ElasticBounds b = hashin_shtrikman(map.fraction, elastic_values(c));
    out.values = {m.bulk, b.bulk.low, b.bulk.high, m.shear, b.shear.low, b.shear.high};
    out.field_name = "von Mises stress for a strain along x, slice across z";
    return out;
  }
  const bool flow = property == Property::Permeability;
  out.title = flow ? "Permeability" : "Conductivity";
  out.value_label = flow ? "permeability, mm²" : "conductivity";
  const auto directions = directions_of(c);
  std::string first;
  for (int a = 0; a < 3; ++a) {
    if (!directions[a]) continue;
    out.names.push_back(kVoigt[a]);
    out.values.push_back(r.effective(a, a));
    if (first.empty() && r.connected[a]) first = kAxes[a];
  }
  if (!flow && map.box.size.minCoeff() > 1) {
    out.bounds = hashin_shtrikman(map.fraction, c.numbers("values"));
    out.bounds_name = "bound if isotropic";
  }
  out.field_name = fmt::format("{} for a slope along {}, slice across z", flow ? "speed" : "flow", first);
  return out;
}

Volume field_of(const Context& c, const PhaseMap& map, const Result& r) {
  Volume out;
  const auto property = c.choice<Property>("property");
  const auto add = [&](const char* name, const std::vector<float>& values) {
    add_number_grid(
        out, name, map.box.size, map.box.spacing, c.work().quiet(),
        [&](std::size_t i) { return values.empty() ? 0 : values[i]; }, map.box.first);
  };
  if (property == Property::Stiffness) {
    add("stress", r.flow);
  } else {
    add(property == Property::Permeability ? "speed" : "flow", r.flow);
    add(property == Property::Permeability ? "pressure" : "potential", r.potential);
  }
  if (map.box.periodic) {
    out.resolution = map.box.size;
  } else {
    out.first = map.box.first;
    out.extent = map.box.size;
  }
  return out;
}

void warn_of_gaps(Context& c, const Result& r) {
  const auto directions = directions_of(c);
  std::string missing;
  for (int a = 0; a < 3; ++a)
    if (directions[a] && !r.connected[a]) missing += (missing.empty() ? "" : ", ") + kAxes[a];
  if (missing.empty()) return;
  c.warn(fmt::format(
      "the phases with a value above 0 do not connect along {}: nothing flows there, and the effective value "
      "is "
      "exactly 0{}",
      missing,
      c.choice<Property>("property") == Property::Conductivity ? ", with an infinite tortuosity" : ""));
}

// The tensor without what was not computed.
Eigen::MatrixXd known(const Context& c, const PhaseMap& map, Eigen::MatrixXd tensor) {
  if (tensor.rows() != 3) return tensor;
  const auto directions = directions_of(c);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!directions[j] || (i != j && !periodic(c, map))) tensor(i, j) = NAN;
  return tensor;
}

void compute(Context& c) {
  const bool elastic = c.choice<Property>("property") == Property::Stiffness;
  const std::size_t count = c.numbers("values").size() / (elastic ? 2 : 1);
  const PhaseMap map =
      read_phases(c.input<Volume>("volume"), c.text("grid"), c.optional<Particles>("particles"), count,
                  c.memory(), c.work().part(0, 0.02));
  check_count(map, count);
  Result r = solve_for(c, map, c.work().part(0.02, 0.88));
  if (!elastic) warn_of_gaps(c, r);
  if (elastic && !map.box.periodic)
    c.warn("the volume does not tile, but stiffness is found as if it did: its opposite sides touch");
  const auto half = half_of(c, map, c.work().part(0.88, 1));
  std::vector<Measure> measures = measures_of(c, map, r);
  if (half) add_coarse_values(measures, measures_of(c, half->map, half->result));
  measures.push_back({"iterations", "iterations", static_cast<double>(r.convergence.iterations), ""});
  measures.push_back({"residual", "residual", r.convergence.residual, ""});
  if (const auto error = voxel_error(r, half))
    measures.push_back({"voxel error, relative", "voxel_error", *error, ""});
  for (const Measure& m : measures)
    if (!m.metric.empty()) c.metric(m.metric, m.value);
  c.output("table", table_of(measures));
  c.output("tensor", tensor_table(known(c, map, r.effective), elastic ? kVoigt : kAxes));
  c.output("field", field_of(c, map, r));
  c.output("figure", figure_of(shown_of(c, map, r), map.box));
}

}  // namespace
}  // namespace terrazzo::homogenize

namespace terrazzo {

NodeType homogenize_node() {
  using namespace homogenize;
  return NodeType("Homogenize", 3)
      .doc_(
          "Finds how well a volume conducts, how stiff it is, or how easily a fluid flows through it, from "
          "the values of its phases: the whole effective tensor, tortuosity, bounds, and the error of the "
          "voxels.")
      .source_(
          "Hashin and Shtrikman 1962, 1963 (bounds); Cooper et al. 2016 (tortuosity); Leute et al. 2022 "
          "(stiffness); "
          "Harlow and Welch 1965 (flow)")
      .input("volume", {"Volume"}, "Voxels whose numbers are phases, labels of particles, or a coverage")
      .optional_input(
          "particles", {"Particles"},
          "Particles of the grid id: their classes become the phases, after the binder and before the voids")
      .output(
          "table", "Table",
          "Effective values, bounds and fractions of the phases, each also at half the resolution, and how "
          "exact they are")
      .output("tensor", "Table",
              "The effective tensor: 3 × 3 for x, y, z, or 6 × 6 for the stresses and engineering strains "
              "xx, yy, zz, yz, "
              "xz, xy. Column j is the response to a slope or strain j; entries that were not computed are "
              "empty.")
      .output("field", "Volume",
              "Conductivity: flow, and potential less its mean slope; permeability: speed and pressure; for "
              "a slope of 1 "
              "along the first connected direction, and for a viscosity of 1. Stiffness: von Mises stress "
              "for a strain xx of 1.")
      .output("figure", "Image", "Effective values beside their bounds, and a slice of the field")
      .parameter(Parameter::choice("property", "conductivity", {"conductivity", "stiffness", "permeability"})
                     .doc_("conductivity: of heat or charge, diffusivity, permittivity. permeability: of the "
                           "phases in "
                           "which a viscous fluid flows, in mm²."))
      .parameter(
          Parameter::numbers("values", {1})
              .range(-1e12, 1e12)
              .count(1, 2 * kMostPhases)
              .required()
              .doc_("Value of each phase, in increasing order of the phases' numbers, or binder first. "
                    "stiffness: "
                    "Young's modulus and Poisson's ratio of each phase, 0 and any ratio for pores. "
                    "permeability: 1 where the "
                    "fluid flows, 0 where not."))
      .parameter(Parameter::text("grid", "")
                     .doc_("Grid that contains the phases. Empty: phase, else id, else density, else the "
                           "only one. Each "
                           "whole number is a phase. For two values, negative labels are the binder and the "
                           "others the "
                           "particles; a coverage is outside below 0.5."))
      .parameter(Parameter::choice("boundary", "auto", {"auto", "periodic", "fixed"})
                     .doc_("What surrounds the volume. fixed: two opposite faces have given values, and the "
                           "others are "
                           "insulated, or walls for a fluid. auto: periodic if the volume tiles or for "
                           "stiffness, else fixed."))
      .parameter(Parameter::texts("directions", {"x", "y", "z"})
                     .count(1, 3)
                     .doc_("Directions of the mean slope. Stiffness uses all strains."))
      .parameter(Parameter::number("tolerance", 1e-5)
                     .range(1e-10, 0.1)
                     .doc_("Largest residual, relative to that of a uniform field. Below 1e-6 stiffness does "
                           "not get."))
      .parameter(Parameter::integer("iterations", 2000)
                     .range(1, 1000000)
                     .doc_("Iterations in one direction after which the node fails"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
