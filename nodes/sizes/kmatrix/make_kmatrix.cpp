#include "nodes/sizes/kmatrix/make_kmatrix.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/size_kernel.h"
#include "nodes/sizes/kmatrix/section_statistics.h"

namespace terrazzo::kmatrix {

KMatrix make_kmatrix(const Shapes& shapes, const KMatrixOptions& options, const Work& work,
                     std::size_t* orientations_used) {
  if (shapes.shapes.empty())
    throw Error("no-shapes", "there are no shapes to cut", "connect at least one shape");
  double total = 0;
  for (const Shape& s : shapes.shapes) {
    if (!(s.probability >= 0) || !std::isfinite(s.probability))
      throw Error("bad-probabilities",
                  fmt::format("the probability of \"{}\" must be 0 or more; it is {}", s.name, s.probability),
                  "correct the probability");
    if (!(s.max_section_area > 0) || !(s.mean_caliper > 0) || !(s.volume > 0) || s.mesh.triangles.empty())
      throw Error("unmeasured-shape",
                  fmt::format("\"{}\" has no mesh, volume, mean caliper diameter or largest section", s.name),
                  "create shapes with nodes that measure them");
    total += s.probability;
  }
  if (!(total > 0))
    throw Error("bad-probabilities", "the probabilities of the shapes are all zero",
                "make at least one positive");

  KMatrix k;
  k.classes = options.classes;
  k.averaging = options.averaging;
  const auto edges = equal_edges(options.classes, 1);
  const double count = shapes.shapes.size();
  // Errors of single shapes average out in a mixture of many.
  constexpr std::size_t kManyShapes = 24;
  std::size_t orientations = options.orientations;
  if (orientations > 0 && shapes.shapes.size() > kManyShapes)
    orientations = std::max<std::size_t>(2, orientations * kManyShapes / shapes.shapes.size());
  std::size_t most = 0;
  for (std::size_t i = 0; i < shapes.shapes.size(); ++i) {
    const Shape& shape = shapes.shapes[i];
    const Work part = work.part(i / count, (i + 1) / count);
    const SectionStatistics s =
        options.method == Method::Analytic ? ellipsoid_statistics(fit_ellipsoid(shape))
        : options.method == Method::Stencil
            ? stencil_statistics(shape, options.classes, options.orientations, options.device, part)
            : slice_statistics(shape, options.classes, orientations, part);
    KMatrix::Entry& e = k.shapes.emplace_back();
    e.probability = shape.probability / total;
    e.trend = shape.trend;
    e.cls = shape.cls;
    e.mean_caliper = s.mean_caliper;
    e.max_section_area = s.max_section_area;
    e.volume = s.volume;
    e.profiles_per_caliper = s.profiles_per_caliper;
    e.cdf = s.cdf;
    e.K = size_kernel(e, edges, edges, options.averaging == "upper_edge");
    k.residual = std::max(k.residual, s.residual);
    most = std::max(most, s.orientations);
  }
  if (orientations_used) *orientations_used = most;
  return k;
}

}  // namespace terrazzo::kmatrix
