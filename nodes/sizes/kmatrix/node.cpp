#include <cmath>

#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/common/stereology/size_kernel.h"
#include "nodes/data/table.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "runtime/context.h"

namespace terrazzo::kmatrix {
namespace {

std::string name_of(const Shapes& shapes, std::size_t i) {
  return shapes.shapes[i].name.empty() ? fmt::format("shape {}", i + 1) : shapes.shapes[i].name;
}

// The probability that a plane that meets a particle of the largest size shows a profile of each class: K's
// last column with every particle at its upper edge, the curves of figure 4.
Table table_of(const KMatrix& k, const Shapes& shapes) {
  Table t;
  t.columns = {"shape", "probability", "mean caliper mm", "largest section mm²", "profiles per caliper"};
  for (int i = 0; i < k.classes; ++i)
    t.columns.push_back(fmt::format("√(A/A_max) ≤ {:.4g}", static_cast<double>(i + 1) / k.classes));
  for (std::size_t s = 0; s < k.shapes.size(); ++s) {
    const auto& e = k.shapes[s];
    auto& row = t.rows.emplace_back();
    row = {name_of(shapes, s), e.probability, e.mean_caliper, e.max_section_area, e.profiles_per_caliper};
    for (int i = 0; i < k.classes; ++i)
      row.emplace_back(e.profiles_per_caliper * (cdf_at(e.cdf, static_cast<double>(i + 1) / k.classes) -
                                                 cdf_at(e.cdf, static_cast<double>(i) / k.classes)));
  }
  return t;
}

Image figure_of(const KMatrix& k, const Shapes& shapes) {
  constexpr int kPoints = 100;
  Plot plot;
  plot.title = "Likelihood of cross-sectional area";
  plot.x_label = "sqrt(A / A_max)";
  plot.y_label = "density";
  for (std::size_t s = 0; s < k.shapes.size(); ++s) {
    PlotSeries line{PlotSeries::Kind::Line, name_of(shapes, s), {}, {}, {}, {}, static_cast<int>(s)};
    for (int i = 0; i < kPoints; ++i) {
      line.x.push_back((i + 0.5) / kPoints);
      line.y.push_back(kPoints * (cdf_at(k.shapes[s].cdf, (i + 1.0) / kPoints) -
                                  cdf_at(k.shapes[s].cdf, static_cast<double>(i) / kPoints)));
    }
    plot.series.push_back(std::move(line));
  }
  return draw(plot);
}

void compute(Context& c) {
  KMatrixOptions options;
  options.method = c.choice<Method>("method");
  options.classes = c.integer("classes");
  options.averaging = c.text("averaging");
  const bool automatic = c.keyword("orientations") == "auto";
  if (!automatic) options.orientations = c.integer("orientations");
  options.device = c.choice<GlDevice>("device");
  std::size_t used = 0;
  KMatrix k = make_kmatrix(c.input<Shapes>("shapes"), options, c.work(), &used);
  if (automatic && options.method == Method::Slice && k.residual > 4e-3)
    c.warn(fmt::format(
        "after {} directions a class still changed by {:.2g} %; use fewer classes, or set orientations", used,
        100 * k.residual));
  double caliper = 0, profiles = 0;
  for (const auto& e : k.shapes) {
    caliper += e.probability * e.mean_caliper;
    profiles += e.probability * e.profiles_per_caliper;
  }
  c.metric("mean_caliper", caliper);
  c.metric("profiles_per_caliper", profiles);
  c.metric("residual", k.residual);
  if (options.method != Method::Analytic) c.metric("orientations", used);
  const Shapes& shapes = c.input<Shapes>("shapes");
  double sum = 0;
  for (const Shape& s : shapes.shapes) sum += s.probability;
  if (std::abs(sum - 1) > 1e-6)
    c.warn(fmt::format("the shapes' probabilities sum to {:.4g}, not 1; they were normalized", sum));
  c.output("table", table_of(k, shapes));
  c.output("figure", figure_of(k, shapes));
  c.output("kmatrix", std::move(k));
}

}  // namespace
}  // namespace terrazzo::kmatrix

namespace terrazzo {

NodeType kmatrix_node() {
  using namespace kmatrix;
  return NodeType("KMatrix", 3)
      .doc_(
          "Computes how often a particle of each size shows a profile of each size in a random plane, for "
          "each shape. Unfold inverts this matrix. Classes are equal bins of √(A/A_max), where A_max is the "
          "area of the largest section over all planes.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 3, eq. 3, 5, 6, 10")
      .input("shapes", "Shapes", "Particle shapes with their probabilities")
      .output("kmatrix", "KMatrix",
              "One matrix per shape, with mean caliper diameter, largest section and profiles per caliper")
      .output("table", "Table", "Measures of each shape and the probability of profiles of each class")
      .output("figure", "Image", "Curves of the probability of profile sizes, as in figure 4")
      .parameter(
          Parameter::choice("method", "slice", {"slice", "analytic", "stencil"})
              .doc_("slice: cuts any closed mesh in quasi-random directions, integrates all depths exactly "
                    "and counts disjoint profiles separately. analytic: closed form for spheres, spheroids "
                    "and ellipsoids; fails if the mesh is not a tessellation of one (vertices within 0.1 %, "
                    "at least 90 % of the volume filled). stencil: the paper's method, which cuts one plane "
                    "at a time and counts pixels with OpenGL's stencil buffer; slower and coarser."))
      .parameter(
          Parameter::integer("classes", 10).range(1, 200).doc_("Number of equal classes of √(A/A_max)"))
      .parameter(Parameter::choice("averaging", "uniform", {"uniform", "upper_edge"})
                     .doc_("Sizes within the class of a column. uniform: evenly distributed over the class. "
                           "upper_edge: all at the upper edge, as in the paper's equation 3, which biases "
                           "the unfolding."))
      .parameter(Parameter::optional_integer("orientations", "auto")
                     .range(2, 10000000)
                     .doc_("Number of directions of slice; more than 24 shapes share those of 24. auto: "
                           "doubles them until no class changes by more "
                           "than 0.1 % (0.4 % for convex bodies of a thousand triangles or more), up to "
                           "65536. For stencil, the number of planes; auto: 16384."))
      .parameter(Parameter::choice("device", "cpu", {"cpu", "gpu"})
                     .doc_("Device on which stencil renders. cpu: Mesa's software renderer. gpu: the first "
                           "GPU with EGL. The results may differ by pixels at edges."))
      .compute_(compute);
}

}  // namespace terrazzo
