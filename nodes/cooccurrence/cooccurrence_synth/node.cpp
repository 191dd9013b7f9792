#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/common/texture/texture_measures.h"
#include "nodes/cooccurrence/cooccurrence_synth/cooccurrence_synth.h"
#include "nodes/data/indices.h"
#include "nodes/data/table.h"
#include "runtime/context.h"

namespace terrazzo::cooccurrence_synth {
namespace {

// The paper's figure 3: error and changed pixels per sweep, for each resolution.
Image figure_of(const SynthResult& r) {
  Plot error, changed;
  error.title = "Error of the co-occurrence matrix";
  error.y_label = "E";
  error.log_y = true;
  changed.title = "Pixels changed";
  changed.y_label = "pixels";
  error.x_label = changed.x_label = "sweep";
  for (const DescentSweep& s : r.sweeps) {
    if (s.sweep == 0)
      for (Plot* p : {&error, &changed}) {
        PlotSeries& series = p->series.emplace_back();
        series.color = count_of(p->series) - 1;
        if (r.sweeps.front().stride > 1)
          series.name = s.stride > 1 ? fmt::format("one of {} pixels", s.stride) : "every pixel";
      }
    if (s.error > 0) {
      error.series.back().x.push_back(s.sweep);
      error.series.back().y.push_back(s.error);
    }
    if (s.sweep > 0)
      changed.series.back().x.push_back(s.sweep),
          changed.series.back().y.push_back(static_cast<double>(s.changed));
  }
  for (Plot* p : {&error, &changed}) {
    p->width = 480;
    p->height = 360;
  }
  return draw({error, changed}, 2);
}

void compute(Context& c) {
  const Image& source = c.input<Image>("image");
  SynthOptions s;
  s.levels = c.integer("levels");
  s.extent = c.integer("extent");
  s.scales = c.integer("scales");
  s.sweeps = c.integer("sweeps");
  s.finish = c.choice<Finish>("finish");
  s.start = c.choice<Start>("start");
  s.tileable = c.boolean("tileable");
  s.space = c.choice<ColorSpace>("space");
  s.seed = c.seed();
  if (c.keyword("size").empty()) {
    const auto size = c.ints("size");
    s.width = size.front();
    s.height = size.back();
  }
  std::vector<std::uint8_t> mask;
  if (c.has("mask")) mask = mask_of(c.value("mask"), source, "mask");
  const SynthResult r = synthesize(source, mask, s, c.work().part(0, 0.9));
  if (r.levels.count() < s.levels)
    c.warn(fmt::format("the picture has only {} different colors; levels is {}", r.levels.count(), s.levels));

  Image out = image_of(r.field, r.levels, source.pixel_size);
  for (std::size_t i = 0; i < r.from.size(); ++i) out.pixels[i] = source.pixels[r.from[i]];
  c.metric("finished_error", r.finished_error);
  c.metric("error_start", r.noise_error);
  c.metric("error", r.sweeps.back().error);
  c.metric("sweeps", r.sweeps.back().sweep);
  c.metric("last_changed", r.sweeps.back().changed);
  Image first(source.width, source.height, 1, source.pixel_size);
  std::copy_n(source.pixels.begin(), first.pixels.size(), first.pixels.begin());
  TexturePart from{&first, mask};
  from.mask.resize(mask.empty() ? 0 : first.pixels.size());
  c.metric("histogram_distance", histogram_distance(from, {&out, {}}));
  c.metric("patch_distance", patch_distance(from, {&out, {}}, 0, c.work()));
  if (mask.empty()) c.metric("patch_distance_floor", patch_distance_floor(first, c.work()));
  c.output("quantized",
           image_of(levels_of(source, 0, r.levels, {}, c.work().quiet()), r.levels, source.pixel_size));
  c.output("figure", figure_of(r));
  c.output("table", descent_table(r.sweeps));
  c.output("image", std::move(out));
}

}  // namespace
}  // namespace terrazzo::cooccurrence_synth

namespace terrazzo {

NodeType cooccurrence_synth_node() {
  using namespace cooccurrence_synth;
  return NodeType("CooccurrenceSynth", 2)
      .doc_("Makes a texture from noise in which colors are neighbors as often as in a picture")
      .source_("Malzbender and Spach 1993, sections 2 and 3, after Gagalowicz and Ma 1985")
      .input("image", "Image", "Texture to match; several sections are measured together")
      .optional_input(
          "mask", {"Labels", "Image"},
          "Where the texture is measured: pixels with a label other than 0, or with a brightness over 0.2")
      .output("image", "Image",
              "Synthesized texture in the levels' colors or, with finish patches, in the picture's own")
      .output("table", "Table",
              "Sweeps at each resolution (one in `stride` pixels): sweep, error E of the matrix (half of the "
              "offsets), pixels changed. Sweep 0 is the start.")
      .output("figure", "Image", "Plot of the table's two curves (the paper's figure 3)")
      .output("quantized", "Image", "First section of the source in the levels' colors")
      .parameter(
          Parameter::integer("levels", 8).range(2, kMostLevels).doc_("Number of colors, found by k-means"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Color space for clustering: Oklab, or display-encoded RGB (as in the paper)"))
      .parameter(Parameter::integer("extent", 2)
                     .range(1, 16)
                     .unit_("pixels")
                     .doc_("Largest offset in x and y, in both directions. 2 is a kernel of 5 × 5 pixels."))
      .parameter(Parameter::integer("scales", 1)
                     .range(1, 8)
                     .doc_("Number of scales. Offsets are also used 2, 4, … times as long, up to 2^(scales − "
                           "1), to capture longer correlations."))
      .parameter(Parameter::choice("start", "coarse", {"coarse", "noise"})
                     .doc_("coarse: starts at a fraction of the resolution and refines, so that long "
                           "structures find their places. noise: full resolution only, as in the paper."))
      .parameter(
          Parameter::integer("sweeps", 10)
              .range(1, 10000)
              .doc_(
                  "Most sweeps over all pixels at each resolution. Ends early when a sweep changes nothing."))
      .parameter(Parameter::with_keyword(ParameterKind::Ints, "size", "auto")
                     .count(1, 2)
                     .range(2, 16384)
                     .unit_("pixels")
                     .doc_("Edge length, or width and height. auto: the picture's size."))
      .parameter(
          Parameter::choice("finish", "levels", {"levels", "patches"})
              .doc_("levels: the clustered colors, as in the paper. patches: colors of source pixels "
                    "with similar neighborhoods, so that shapes survive; the levels are updated to match."))
      .parameter(Parameter::boolean("tileable", true).doc_("Makes opposite edges match"))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
