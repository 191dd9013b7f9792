#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/data/indices.h"
#include "nodes/data/table.h"
#include "nodes/media/micrograph/find_phases.h"
#include "nodes/media/micrograph/learn_phases.h"
#include "nodes/media/micrograph/unobserved.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::phases {
namespace {
using namespace media;

constexpr double kRare = 0.005;  // share below which a phase may be dirt
constexpr double kBlurred = 1;   // separation below which noise hides the phases
constexpr double kUnsure = 0.1;  // share of pixels

// 1 where no phase is known.
Labels labels_of(const PhaseMap& map, const std::vector<std::uint8_t>& unobserved) {
  Labels out;
  out.width = map.width;
  out.height = map.height;
  out.pixel_size = map.pixel_size;
  out.ids.assign(map.at.size(), 0);
  std::copy(unobserved.begin(), unobserved.end(), out.ids.begin());
  if (!unobserved.empty()) out.classes = {0};
  return out;
}

// The picture beside its phases in their mean colors.
Image figure_of(const Image& image, const FoundPhases& found) {
  const Vec3f none(0.6f, 0.05f, 0.05f);
  Image out(2 * image.width, image.height, 1, image.pixel_size);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t p = found.map.at[found.map.index(x, y)];
      out.at(x, y) = image.at(x, y);
      out.at(image.width + x, y) = p == kUnobserved ? none : found.color[p];
    }
  return out;
}

void warn_of(Context& c, const FoundPhases& found, const std::vector<double>& fractions, bool by_level) {
  for (std::size_t k = 0; k < fractions.size(); ++k)
    if (fractions[k] < kRare)
      c.warn(
          fmt::format("phase {} fills {:.2f} % of the picture: it may be dirt or the edges of another phase; "
                      "if so, use a mask or fewer phases",
                      k, 100 * fractions[k]));
  if (by_level && found.separation < kBlurred)
    c.warn(
        fmt::format("the noise is as large as the contrast: the levels of two phases differ by {:.2f} times "
                    "the sum of their noise. Their borders are uncertain; use a picture with less noise",
                    found.separation));
  else if (found.uncertain > kUnsure)
    c.warn(fmt::format("{:.0f} % of the pixels are less than 90 % sure of their phase; look at the figure",
                       100 * found.uncertain));
}

// Of the pixels that are not ignored: by strokes if there are any, else by gray levels.
FoundPhases find(Context& c, const Image& image, const std::vector<std::uint8_t>& unobserved) {
  const auto& strokes = c.list("strokes");
  PhaseOptions options;
  options.phases = static_cast<int>(c.optional_integer("phases").value_or(0));
  options.smoothing = c.number("smoothing");
  options.shading = c.boolean("shading");
  if (strokes.empty()) return find_phases(image, unobserved, options, c.work().part(0.2, 1));
  if (options.phases != 0 && options.phases != count_of(strokes))
    throw Error(
        "bad-value",
        fmt::format("there are strokes for {} phases, but phases is {}", strokes.size(), options.phases),
        "set phases to auto")
        .parameter("phases");
  std::vector<const Strokes*> taught;
  for (const auto& s : strokes) taught.push_back(&s.as<Strokes>());
  return learn_phases(image, unobserved, taught, options.smoothing, c.seed(), c.work().part(0.2, 1));
}

void compute(Context& c) {
  const Image& image = c.input<Image>("image");
  if (image.sections > 1)
    c.warn(fmt::format("the image has {} sections; only the first is used", image.sections));
  const bool by_level = c.list("strokes").empty();
  require_memory(by_level ? phases_forecast(image) : learn_forecast(image), c.memory(),
                 "the phases of the picture");
  const auto unobserved = unobserved_pixels(
      image, c.optional<Labels>("mask"), c.boolean("find_objects"),
      [&](const std::string& text) { c.warn(text + "; if they show material, set find_objects to false"); },
      c.work().part(0, 0.2));
  const FoundPhases found = find(c, image, unobserved);
  const auto fractions = fractions_of(found.map);
  warn_of(c, found, fractions, by_level);
  Table table;
  table.columns = {"phase", "fraction", "level", "noise"};
  for (std::size_t k = 0; k < fractions.size(); ++k) {
    table.rows.push_back({static_cast<double>(k), fractions[k], found.level[k], found.noise[k]});
    c.metric(fmt::format("fraction_{}", k), fractions[k]);
  }
  c.metric("phases", found.map.phases);
  c.metric("separation", found.separation);
  c.metric("uncertain", found.uncertain);
  c.metric("shading", found.shading);
  c.output("figure", figure_of(image, found));
  c.output("labels", labels_of(found.map));
  c.output("unobserved", labels_of(found.map, unobserved));
  c.output("table", std::move(table));
}

}  // namespace
}  // namespace terrazzo::phases

namespace terrazzo {

NodeType phases_node() {
  using namespace phases;
  NodeType type =
      NodeType("Phases", 3)
          .doc_(
              "Finds the phases of a micrograph by gray level, in spite of noise and uneven light, or by "
              "strokes")
          .source_("Zhang, Brady and Smith 2001; Otsu 1979; Weszka and Rosenfeld 1979; Berg et al. 2019")
          .input("image", "Image", "Micrograph, in gray or color")
          .optional_input("mask", {"Labels"}, "Pixels to ignore, where labels are not 0, such as cracks")
          .input_list("strokes", {"Strokes"},
                      "Strokes on each phase, first those on phase 0. Every other pixel gets the phase that "
                      "it looks most like.")
          .output(
              "labels", "Labels",
              "Phase at each pixel, 0 for the darkest or first stroked; phase p > 0 is profile p. Ignored "
              "pixels are 0.")
          .output("unobserved", "Labels", "1 at ignored pixels, for `masks` of MediaSolid")
          .output("table", "Table", "Fraction, gray level and noise of each phase")
          .output("figure", "Image", "The picture beside its phases; ignored pixels are red")
          .parameter(Parameter::optional_integer("phases", "auto")
                         .range(2, kMostPhases)
                         .doc_("Number of phases. auto: as many as the histogram has peaks, at most 5, or as "
                               "there are strokes."))
          .parameter(
              Parameter::number("smoothing", 1)
                  .range(0, 10)
                  .doc_("Weight of a neighbor in the same phase. More removes more noise, and fine details."))
          .parameter(Parameter::boolean("shading", true)
                         .doc_("Whether slow changes of light are removed; not with strokes"))
          .parameter(Parameter::boolean("find_objects", true)
                         .doc_("Whether captions, scale bars and rulers are found and ignored; warnings name "
                               "their places"))
          .parameter(Parameter::seed())
          .compute_(compute);
  for (Port& p : type.inputs) p.optional = p.optional || p.name == "strokes";
  return type;
}

}  // namespace terrazzo
