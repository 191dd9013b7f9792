#include "nodes/solids/synthesis/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "nodes/data/labels.h"
#include "nodes/solids/synthesis/whole/measures.h"

namespace terrazzo::solids {
namespace {

constexpr const char* kPorts[3] = {"exemplar", "exemplar_y", "exemplar_z"};

// Visits the first section with rows running upwards.
template <class Use>
void each_upwards(int width, int height, Use&& use) {
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x) use(x, y);
}

SolidExemplar exemplar_of(Context& c, const char* port, int which) {
  const Image& image = c.input<Image>(port);
  if (image.width < 16 || image.height < 16)
    throw Error("exemplar-too-small", fmt::format("{} has {} × {} pixels", port, image.width, image.height),
                "use at least 16 × 16 pixels: patches have 8 × 8");
  if (image.sections > 1)
    c.warn(fmt::format("{} has {} sections; only the first is used", port, image.sections));
  SolidExemplar e;
  e.width = image.width;
  e.height = image.height;
  each_upwards(e.width, e.height, [&](int x, int y) {
    const Vec3f& p = image.at(x, y);
    if (!p.allFinite())
      throw Error("bad-pixels", fmt::format("{} is NaN or infinite at ({}, {})", port, x, y),
                  "replace the bad pixels in the picture");
    e.pixels.push_back(p);
  });
  const auto fits = [&](const char* what, int width, int height) {
    if (width != e.width || height != e.height)
      throw Error("size-mismatch",
                  fmt::format("{} {} has {} × {} pixels, {} has {} × {}", what, which + 1, width, height,
                              port, e.width, e.height),
                  "use pictures of the same size");
  };
  const auto& masks = c.list("masks");
  if (which < count_of(masks)) {
    if (masks[which].is<Labels>()) {
      const Labels& m = masks[which].as<Labels>();
      fits("mask", m.width, m.height);
      each_upwards(e.width, e.height,
                   [&](int x, int y) { e.usable.push_back(m.ids[m.index(x, y, 0)] != 0); });
    } else {
      const Image& m = masks[which].as<Image>();
      fits("mask", m.width, m.height);
      each_upwards(e.width, e.height, [&](int x, int y) { e.usable.push_back(m.at(x, y).mean() > 0.2f); });
    }
  }
  const auto& features = c.list("features");
  if (which < count_of(features)) {
    const Image& f = features[which].as<Image>();
    fits("features", f.width, f.height);
    each_upwards(e.width, e.height, [&](int x, int y) { e.features.push_back(f.at(x, y)); });
  }
  return e;
}

// Shrinks the exemplar until its shorter side has at most `most` pixels. Returns the factor (≥ 1) by which
// its pixels grew.
double fit(SolidExemplar& e, int most) {
  const int side = std::min(e.width, e.height);
  if (side <= most) return 1;
  const double by = static_cast<double>(most) / side;
  e = shrink(e, std::lround(e.width * by), std::lround(e.height * by));
  return 1 / by;
}

std::array<int, 3> planes_of(Context& c, const std::vector<SolidExemplar>& exemplars,
                             const std::array<int, 3>& source) {
  std::array<int, 3> plane = {-1, -1, -1};
  if (c.keyword("planes").empty()) {
    for (const auto& name : c.texts("planes")) {
      const auto axis = std::find(std::begin(kAxes), std::end(kAxes), name) - std::begin(kAxes);
      if (axis == 3)
        throw Error("bad-value", fmt::format("'{}' is not an axis", name), "choose from x, y and z")
            .parameter("planes");
      plane[axis] = source[axis];
    }
    if (std::count(plane.begin(), plane.end(), -1) > 1)
      c.warn("only one plane is constrained, so successive slices of the solid are unrelated");
    return plane;
  }
  // Grain in one picture cannot run the same way on all three planes, but it can on two planes that share an
  // axis.
  const double directed = directedness(exemplars[0]);
  c.metric("directedness", directed);
  if (exemplars.size() == 1 && directed > 0.35) {
    c.warn(fmt::format(
        "the exemplar is directional ({:.2f}, where 1 means stripes), which three planes cannot all show: "
        "only slices across x and y are matched, upright in both. Set planes to choose others.",
        directed));
    return {source[0], source[1], -1};
  }
  return source;
}

}  // namespace

SolidRequest read_request(Context& c, SolidMethod method) {
  SolidRequest request;
  SolidOptions& s = request.settings;
  std::vector<SolidExemplar>& exemplars = request.exemplars;
  s.size = one_or_three(c, "size");
  std::array<int, 3> source = {0, 0, 0};
  std::vector<std::string> ports;  // of each exemplar
  for (int a = 0; a < 3; ++a) {
    if (!c.has(kPorts[a])) continue;
    source[a] = exemplars.size();
    ports.push_back(kPorts[a]);
    exemplars.push_back(exemplar_of(c, kPorts[a], exemplars.size()));
  }
  for (const char* list : {"masks", "features"})
    if (c.list(list).size() > exemplars.size())
      throw Error("too-many-inputs",
                  fmt::format("{} {} for {} exemplars", c.list(list).size(), list, exemplars.size()),
                  "connect at most one per exemplar, in the same order");
  request.voxel = c.input<Image>("exemplar").pixel_size;
  const int most = c.keyword("exemplar_size").empty() ? static_cast<int>(c.integer("exemplar_size"))
                                                      : std::max(64, s.size.maxCoeff());
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    const int width = exemplars[e].width, height = exemplars[e].height;
    const double by = fit(exemplars[e], most);
    if (e == 0) request.voxel *= by;
    if (by > 1 && !c.keyword("exemplar_size").empty())
      c.warn(
          fmt::format("{} is reduced from {} × {} to {} × {} pixels, so that it fits the solid; set "
                      "exemplar_size to keep "
                      "its details",
                      ports[e], width, height, exemplars[e].width, exemplars[e].height));
  }
  for (std::size_t e = 1; e < exemplars.size(); ++e)
    if (std::min(exemplars[e].width, exemplars[e].height) !=
        std::min(exemplars[0].width, exemplars[0].height))
      c.warn(fmt::format("exemplars have {} × {} and {} × {} pixels: a pixel of either is one voxel",
                         exemplars[0].width, exemplars[0].height, exemplars[e].width, exemplars[e].height));
  s.plane = planes_of(c, exemplars, source);
  s.iterations.clear();
  s.method = method;
  s.blockwise_iterations = c.keyword("iterations").empty() ? 0 : SolidOptions().blockwise_iterations;
  if (!c.keyword("iterations").empty())
    s.iterations =
        s.method == SolidMethod::Reference ? std::vector<int>{100, 20, 10} : std::vector<int>{20, 10, 5};
  else
    for (const auto i : c.ints("iterations")) s.iterations.push_back(static_cast<int>(i));
  s.levels = c.optional_integer("levels").value_or(0);
  s.color = c.choice<SolidColor>("color");
  s.exponent = c.number("exponent");
  s.overuse = c.number("overuse");
  s.copying = c.number("copying");
  s.window = c.number("window");
  s.guide = c.number("guide");
  s.finish = !c.keyword("finish").empty() ? (s.method == SolidMethod::Blockwise ? 1 : 2)
                                          : static_cast<int>(c.integer("finish"));
  s.seed = c.seed();
  return request;
}

void check_request(Context& c, const SolidRequest& r, double bytes) {
  const SolidOptions& s = r.settings;
  if (bytes > c.number("memory") * 1e6)
    throw Error("too-large",
                fmt::format("{} × {} × {} voxels need about {:.0f} MB; the limit is {:.0f} MB", s.size.x(),
                            s.size.y(), s.size.z(), bytes / 1e6, c.number("memory")),
                "make the solid smaller (it tiles), or raise memory")
        .parameter("size");
  if (const double coarse = coarseness(r.exemplars[0]); coarse > 0.7)
    c.warn(
        fmt::format("{:.0f} % of the exemplar's variance comes from details larger than an eighth of its "
                    "side: it shows too few of them to reconstruct their arrangement",
                    100 * coarse));
}

NodeType& declare_exemplars(NodeType& type) {
  type.input("exemplar", "Image",
             "Exemplar for slices across x, and for slices across y and z that have no exemplar of their "
             "own. On x and y a picture's columns run along y and x and its rows upwards along z; on z they "
             "run along x and y.")
      .optional_input("exemplar_y", {"Image"},
                      "Exemplar for slices across y. A pixel is one voxel, as in exemplar.")
      .optional_input("exemplar_z", {"Image"}, "Exemplar for slices across z")
      .input_list("masks", {"Labels", "Image"},
                  "Usable parts of the exemplars, one mask per exemplar in their order. A pixel is usable if "
                  "its label is not 0 or its brightness exceeds 0.2.")
      .input_list("features", {"Image"},
                  "Three extra values per exemplar pixel (height, roughness, a distance), one image per "
                  "exemplar in their order. Synthesis carries them along with the colors.");
  for (Port& p : type.inputs) p.optional |= p.many;
  return type;
}

NodeType& declare_size(NodeType& type) {
  return type
      .parameter(Parameter::ints("size", {128})
                     .count(1, 3)
                     .range(16, 4096)
                     .unit_("voxels")
                     .doc_("Edge length, or one length per axis"))
      .parameter(Parameter::optional_integer("exemplar_size", "auto")
                     .range(16, 4096)
                     .unit_("pixels")
                     .doc_("Shorter side to which larger exemplars are reduced before synthesis; voxels grow "
                           "with the pixels. auto: the solid's longest edge, at least 64."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Ints, "iterations", "auto")
              .count(1, 8)
              .range(1, 1000)
              .doc_("Iterations per level, starting with the coarsest. The last number applies to all "
                    "remaining levels. auto: 20, 10, 5, and 2 on blockwise levels; with method reference "
                    "100, 20, 10."));
}

NodeType& declare_settings(NodeType& type) {
  return type
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "planes", "auto")
                     .count(1, 3)
                     .doc_("Axes across which slices must look like an exemplar: [x, y, z] or fewer. auto: "
                           "all three, but only x and y if a single exemplar is directional."))
      .parameter(Parameter::optional_integer("levels", "auto")
                     .range(1, 8)
                     .doc_("Number of scales, each half the size of the next. auto: until the exemplar's "
                           "shorter side has 24 to 47 pixels."))
      .parameter(Parameter::choice("color", "lab", {"lab", "linear", "rgb"})
                     .doc_("Color space for distances and means: Oklab, scene-linear Rec. 709, or "
                           "display-encoded RGB with a histogram per channel (as in the 2011 paper)"))
      .parameter(Parameter::number("exponent", 0.8)
                     .range(0, 2)
                     .doc_("Exponent r of the energy ‖patch − match‖^r. Values below 2 reduce the influence "
                           "of bad matches."))
      .parameter(Parameter::number("overuse", 1)
                     .range(0, 100)
                     .doc_("Penalty on exemplar patches that are used more often than average. With 0 one "
                           "motif may repeat."))
      .parameter(Parameter::number("copying", 1)
                     .range(0, 100)
                     .doc_("Penalty on patches that copy their neighbors' exemplar layout verbatim. With 0 "
                           "whole pieces are copied; large values break structures up."))
      .parameter(
          Parameter::number("guide", 1)
              .range(0, 10)
              .doc_("Weight of the guidance channel, the distance to the border between dark and light, "
                    "where all colors together weigh 1. It keeps veins and joints in one piece. Not used by "
                    "method reference; with method blockwise only on levels that are made whole."))
      .parameter(
          Parameter::number("window", 0.05)
              .range(0, 10)
              .doc_("Mean shift window at the end of each level, in standard deviations of the exemplars. It "
                    "starts ten times as wide. With 0 voxels become plain means, which blur."))
      .parameter(Parameter::optional_integer("finish", "auto")
                     .range(0, 20)
                     .doc_("Rounds of matching the finest bands of all slices to the exemplar's distribution "
                           "at the end. auto: 2; with method blockwise 1, with filters that reach 9 voxels."))
      .parameter(Parameter::number("memory", 4000)
                     .range(1, 1e7)
                     .unit_("MB")
                     .doc_("Memory limit. Sizes that need more are refused before any work starts."))
      .parameter(Parameter::seed());
}

}  // namespace terrazzo::solids
