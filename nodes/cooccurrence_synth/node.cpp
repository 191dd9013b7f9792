#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/plot.h"
#include "nodes/common/texture_measures.h"
#include "nodes/cooccurrence_synth/cooccurrence_synth.h"
#include "nodes/data/table.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

using namespace cooccurrence_synth;

// Figure 3 of the paper: the error, and the pixels changed, sweep by sweep, of each resolution.
Image figure_of(const SynthResult& r) {
  Plot error, changed;
  error.title = "Error of the co-occurrence matrix", error.y_label = "E", error.log_y = true;
  changed.title = "Pixels changed", changed.y_label = "pixels";
  error.x_label = changed.x_label = "sweep";
  for (const DescentSweep& s : r.sweeps) {
    if (s.sweep == 0)
      for (Plot* p : {&error, &changed}) {
        PlotSeries& series = p->series.emplace_back();
        series.color = static_cast<int>(p->series.size()) - 1;
        if (r.sweeps.front().stride > 1)
          series.name = s.stride > 1 ? fmt::format("one of {} pixels", s.stride) : "every pixel";
      }
    if (s.error > 0) error.series.back().x.push_back(s.sweep), error.series.back().y.push_back(s.error);
    if (s.sweep > 0)
      changed.series.back().x.push_back(s.sweep),
          changed.series.back().y.push_back(static_cast<double>(s.changed));
  }
  for (Plot* p : {&error, &changed}) p->width = 480, p->height = 360;
  return draw({error, changed}, 2);
}

void compute(Context& c) {
  const Image& source = c.input<Image>("image");
  SynthSettings s;
  s.levels = static_cast<int>(c.integer("levels")), s.extent = static_cast<int>(c.integer("extent"));
  s.scales = static_cast<int>(c.integer("scales")), s.sweeps = static_cast<int>(c.integer("sweeps"));
  s.patches = c.text("finish") == "patches", s.from_noise = c.text("start") == "noise";
  s.tileable = c.boolean("tileable"), s.space = c.text("space");
  s.seed = static_cast<std::uint64_t>(c.integer("seed"));
  if (c.keyword("size").empty()) {
    const auto size = c.ints("size");
    s.width = static_cast<int>(size.front()), s.height = static_cast<int>(size.back());
  }
  std::vector<std::uint8_t> mask;
  if (c.has("mask")) mask = mask_of(c.value("mask"), source, "mask");
  const SynthResult r = synthesize(source, mask, s, c.work().part(0, 0.9));
  if (r.levels.count() < s.levels)
    c.warn(fmt::format("the picture has only {} different colours, {} levels were asked for",
                       r.levels.count(), s.levels));

  Image out = image_of(r.field, r.levels, source.pixel_size);
  for (std::size_t i = 0; i < r.from.size(); ++i) out.pixels[i] = source.pixels[r.from[i]];
  c.metric("finished_error", r.finished_error);
  c.metric("error_start", r.noise_error);
  c.metric("error", r.sweeps.back().error);
  c.metric("sweeps", r.sweeps.back().sweep);
  c.metric("last_changed", static_cast<double>(r.sweeps.back().changed));
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

NodeType cooccurrence_synth_node() {
  return NodeType("CooccurrenceSynth", 2)
      .doc_("Makes a texture from noise whose colours neighbour each other as often as a picture's do")
      .source_("Malzbender and Spach 1993, sections 2 and 3, after Gagalowicz and Ma 1985")
      .input("image", "Image", "the texture; several sections count together")
      .optional_input("mask", {"Labels", "Image"},
                      "where the texture is measured: labels other than 0, or brighter than 0.2")
      .output("image", "Image",
              "the field, in the levels' colours or, with finish patches, the picture's own")
      .output(
          "table", "Table",
          "of each resolution, one of `stride` pixels: sweep, error E of the matrix (half of the offsets), "
          "pixels changed; sweep 0 is its start")
      .output("figure", "Image", "the table's two curves (the paper's figure 3)")
      .output("quantized", "Image", "the source's first section in the levels' colours")
      .parameter(Parameter::integer("levels", 8).range(2, kMostLevels).doc_("Colours, found by k-means"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Where colours are clustered: Oklab, or RGB as displays show it (the paper's)"))
      .parameter(Parameter::integer("extent", 2)
                     .range(1, 16)
                     .unit_("pixels")
                     .doc_("Offsets go up to ± this in x and y: 2 is a kernel of 5 × 5"))
      .parameter(Parameter::integer("scales", 1)
                     .range(1, 8)
                     .doc_("The offsets are also taken 2, 4, … times as long, up to 2^(scales − 1), for "
                           "longer correlations"))
      .parameter(
          Parameter::choice("start", "coarse", {"coarse", "noise"})
              .doc_(
                  "coarse: made at half, a quarter, … of the resolution first, so that long structures find "
                  "their places. noise: at full resolution alone, the paper's"))
      .parameter(
          Parameter::integer("sweeps", 10)
              .range(1, 10000)
              .doc_("Visits of every pixel at each resolution, at most; it ends when one changes nothing"))
      .parameter(Parameter::with_keyword(ParameterKind::Ints, "size", "auto")
                     .count(1, 2)
                     .range(2, 16384)
                     .unit_("pixels")
                     .doc_("Edge, or width and height; auto: the picture's"))
      .parameter(Parameter::choice("finish", "levels", {"levels", "patches"})
                     .doc_("levels: their few colours, the paper's. patches: colours of the source's pixels "
                           "in like surroundings, "
                           "levels following, so that shapes survive"))
      .parameter(Parameter::boolean("tileable", true).doc_("Opposite edges continue each other"))
      .parameter(Parameter::integer("seed", 1)
                     .range(0, 9007199254740991)
                     .doc_("Of the noise and the order of visits"))
      .compute_(compute);
}

}  // namespace terrazzo
