#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/dense_grid.h"
#include "nodes/common/steerable_pyramid.h"
#include "nodes/residual_synth/residual_image.h"
#include "nodes/residual_synth/synthesize.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

Vec3i volume_size(const Context& c) {
  const auto written = c.ints("size");
  if (written.size() == 2)
    throw Error("bad-value", "two numbers", "write one size, or three").parameter("size");
  Vec3i size;
  for (int a = 0; a < 3; ++a) size[a] = static_cast<int>(written.size() == 1 ? written[0] : written[a]);
  if (size.cast<double>().prod() > 5.4e8)
    throw Error("too-large", fmt::format("{} × {} × {} voxels", size.x(), size.y(), size.z()),
                "at most 800³: the volume tiles")
        .parameter("size");
  return size;
}

void compute(Context& c) {
  const auto& image = c.input<Image>("image");
  const Vec3i size = volume_size(c);
  const Work& work = c.work();
  const auto edge = static_cast<int>(c.integer("edge"));
  const ResidualImage residual =
      residual_image(as_displayed(image, work.part(0, 0.01)), c.input<Labels>("labels"), edge,
                     c.number("specks"), work.part(0.01, 0.05));
  if (residual.edge < edge)
    c.warn(fmt::format("outlines are left out by {} pixels instead of {}: little else would be left",
                       residual.edge, edge));
  const int scales = pyramid_scales(std::min({size.minCoeff(), image.width, image.height}));
  const Exemplar exemplar = measure_exemplar(residual.image, scales, work.part(0.05, 0.15));
  if (exemplar.channels == 0)
    c.warn("nothing is left of the photograph without its profiles' colours: the residual is zero");
  SynthReport report;
  const auto voxels =
      synthesize_residual(exemplar, size, static_cast<int>(c.integer("rounds")),
                          static_cast<std::uint64_t>(c.integer("seed")), report, work.part(0.15, 0.95));

  initialize_openvdb();
  Volume volume;
  volume.resolution = size;
  volume.grids = {dense_grid<openvdb::Vec3SGrid>(
      "residual", size, image.pixel_size, work.part(0.95, 1),
      [&](std::size_t i) { return openvdb::Vec3s(voxels[i].x(), voxels[i].y(), voxels[i].z()); })};
  c.metric("filled", residual.filled);
  c.metric("specks", residual.specks);
  c.metric("deviation", exemplar.channels > 0 ? exemplar.values[0].deviation : 0);
  for (std::size_t s = 0; s < report.deviation.size(); ++s)
    c.metric(s == 0                             ? "band_high"
             : s + 1 == report.deviation.size() ? "band_low"
                                                : fmt::format("band_{}", s),
             report.deviation[s]);
  c.output("volume", std::move(volume));
}

}  // namespace

NodeType residual_synth_node() {
  return NodeType("ResidualSynth", 3)
      .doc_(
          "Synthesises a tileable solid of the fine detail that a photograph shows within particles and "
          "binder, at the "
          "photograph's scale.")
      .source_("Heeger, Bergen 1995; Jagnow, Dorsey, Rushmeier 2004, section 4.3; Moisan 2011")
      .input("image", "Image", "the photograph, one or more sections")
      .input("labels", "Labels", "its profiles; all zero for a picture without particles")
      .output("volume", "Volume",
              "grid residual: offsets of mean 0 to the sRGB-encoded colour, one voxel a pixel, periodic")
      .parameter(
          Parameter::ints("size", {128})
              .count(1, 3)
              .range(16, 2048)
              .unit_("voxels")
              .doc_("Edge, or one for each axis; multiples of 16 and products of 2, 3 and 5 are fastest"))
      .parameter(Parameter::integer("seed", 1)
                     .range(0, 9007199254740991)
                     .doc_("Of the noise that synthesis starts from"))
      .parameter(
          Parameter::choice("method", "slices", {"slices"})
              .doc_(
                  "slices: a steerable pyramid on all slices across each axis, matched to the photograph's"))
      .parameter(Parameter::integer("rounds", 4)
                     .range(0, 100)
                     .doc_("Of matching; 0 leaves Gaussian noise of the photograph's spectrum and values"))
      .parameter(Parameter::integer("edge", 2).range(0, 32).unit_("pixels").doc_(
          "Pixels to each side of outlines that are filled from beyond instead of used"))
      .parameter(Parameter::number("specks", 6)
                     .range(0, 1e6)
                     .doc_("Binder pixels more than this many robust standard deviations from the binder's "
                           "median are particles that the "
                           "labels miss: they are filled like outlines. 0 keeps them"))
      .compute_(compute);
}

}  // namespace terrazzo
