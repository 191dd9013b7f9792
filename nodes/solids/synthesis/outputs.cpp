#include "nodes/solids/synthesis/outputs.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/gl/open_gl.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"

namespace terrazzo::solids {
namespace {

Table table_of(const std::vector<PlaneMeasures>& measures) {
  Table t;
  t.columns = {"axis",   "histogram",    "patches",       "patches floor",
               "copied", "copied worst", "stripes worst", "seam"};
  for (std::size_t b = 0; b < measures[0].bands.size(); ++b)
    t.columns.push_back(b == 0                              ? "band high"
                        : b + 1 == measures[0].bands.size() ? "band low"
                                                            : fmt::format("band {}", b));
  for (const auto& m : measures) {
    std::vector<Table::Cell> row = {kAxes[m.axis], m.histogram,    m.patches,       m.patches_floor,
                                    m.copied,      m.copied_worst, m.stripes_worst, m.seam};
    for (std::size_t b = 0; b < measures[0].bands.size(); ++b)
      row.emplace_back(b < m.bands.size() ? m.bands[b] : 1.0);
    t.rows.push_back(std::move(row));
  }
  return t;
}

// The worst value of all planes: the one farthest from 1, or the largest.
template <class Get>
double worst(const std::vector<PlaneMeasures>& measures, Get&& get, double from) {
  double out = from;
  for (const auto& m : measures)
    if (std::abs(get(m) - from) > std::abs(out - from)) out = get(m);
  return out;
}

}  // namespace

std::unique_ptr<BlockGl> open_device(Context& c) {
  return open_gl(c, "made", [](GlDevice device) { return std::make_unique<BlockGl>(device); });
}

void give_solid(Context& c, SolidResult&& r, const std::vector<SolidExemplar>& exemplars, bool whole,
                double voxel, const Work& last) {
  const bool features = !r.sources.features.empty(), sources = c.boolean("sources");
  initialize_openvdb();
  Volume volume;
  if (whole) {
    volume.resolution = r.size;
  } else {
    volume.first = r.origin;
    volume.extent = r.size;
  }
  volume.grids.push_back(dense_grid<openvdb::Vec3SGrid>(
      "Cd", r.size, voxel, last,
      [&](std::size_t i) {
        Vec3f w = Vec3f::Zero();
        for (std::size_t k = 0; k < r.field.channel.size(); ++k) w[k] = r.field.channel[k][i];
        const Vec3f v = r.axes.from(w);
        return openvdb::Vec3s(v.x(), v.y(), v.z());
      },
      r.origin));
  r.field = {};
  if (features)
    volume.grids.push_back(dense_grid<openvdb::Vec3SGrid>(
        "features", r.size, voxel, last.quiet(),
        [&](std::size_t i) {
          const Vec3f& f = r.sources.features[i];
          return openvdb::Vec3s(f.x(), f.y(), f.z());
        },
        r.origin));
  if (sources)
    volume.grids.push_back(dense_grid<openvdb::Vec3IGrid>(
        "source", r.size, voxel, last.quiet(),
        [&](std::size_t i) {
          const SolidExemplar& e = exemplars[r.sources.exemplar[i]];
          const int at = r.sources.texel[i];
          return openvdb::Vec3i(at % e.width, e.height - 1 - at / e.width, r.sources.exemplar[i]);
        },
        r.origin));
  c.metric("levels", r.levels);
  c.metric("voxel", voxel);
  const auto& m = r.measures;
  c.metric("patch_distance", worst(
                                 m, [](const auto& p) { return p.patches; }, 0));
  c.metric("patch_distance_floor", worst(
                                       m, [](const auto& p) { return p.patches_floor; }, 0));
  c.metric("histogram_distance", worst(
                                     m, [](const auto& p) { return p.histogram; }, 0));
  c.metric("finest_band", worst(
                              m, [](const auto& p) { return p.bands[0]; }, 1));
  c.metric("copied_worst", worst(
                               m, [](const auto& p) { return p.copied_worst; }, 0));
  c.metric("stripes_worst", worst(
                                m, [](const auto& p) { return p.stripes_worst; }, 1));
  if (whole)
    c.metric("seam_ratio", worst(
                               m, [](const auto& p) { return p.seam; }, 1));
  c.output("table", table_of(m));
  c.output("volume", std::move(volume));
}

NodeType& declare_solid(NodeType& type) {
  return type
      .output("volume", "Volume",
              "Grid Cd: scene-linear color, one voxel per pixel, periodic. With features also the grid "
              "features. With sources also the grid source: column and row (from the top) in the exemplar as "
              "synthesized, and the exemplar's number.")
      .output("table", "Table", "How closely the slices across each constrained axis match their exemplar");
}

NodeType& declare_device(NodeType& type) {
  return type.parameter(
      Parameter::choice("device", "cpu", {"cpu", "auto", "gl"})
          .doc_("Where method blockwise runs its passes. cpu: identical bits on every machine. "
                "gl: OpenGL, on a GPU or else by Mesa's software renderer. auto: a GPU if "
                "there is one, else cpu. A warning names the device used. Rounding differs "
                "between devices, so avoid auto if machines share a cache."));
}

NodeType& declare_sources(NodeType& type) {
  return type.parameter(
      Parameter::boolean("sources", false).doc_("Also writes the exemplar pixel that each voxel comes from"));
}

}  // namespace terrazzo::solids
