#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/dense_grid.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/table.h"
#include "nodes/solid_optimize/local_gl.h"
#include "nodes/solid_optimize/measures.h"
#include "nodes/solid_optimize/solid_optimize.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace solid_optimize;

constexpr const char* kPorts[3] = {"exemplar", "exemplar_y", "exemplar_z"};
constexpr const char* kAxes[3] = {"x", "y", "z"};
constexpr int kLeastBlock = 16;  // voxels

Vec3i solid_size(const Context& c) {
  const auto written = c.ints("size");
  if (written.size() == 2)
    throw Error("bad-value", "two numbers", "write one size, or three").parameter("size");
  Vec3i size;
  for (int a = 0; a < 3; ++a) size[a] = static_cast<int>(written.size() == 1 ? written[0] : written[a]);
  return size;
}

// How a local solid is cut, and which block of it is wanted.
void take_blocks(Context& c, SolidSettings& s) {
  const auto blocks = c.ints("blocks");
  if (blocks.size() == 2)
    throw Error("bad-value", "two numbers", "write one number of blocks, or three").parameter("blocks");
  for (int a = 0; a < 3; ++a)
    s.blocks[a] = static_cast<int>(blocks.size() == 1 ? blocks[0] : blocks[static_cast<std::size_t>(a)]);
  s.block = static_cast<int>(c.integer("block"));
  const int count = s.blocks.prod();
  if (count > 1 && !s.local)
    throw Error("bad-value", fmt::format("by method {} a solid is not made in blocks", c.text("method")),
                "set method: local")
        .parameter("blocks");
  for (int a = 0; a < 3; ++a)
    if (s.size[a] / s.blocks[a] < kLeastBlock)
      throw Error(
          "bad-value",
          fmt::format("{} blocks along {} voxels are thinner than {}", s.blocks[a], s.size[a], kLeastBlock),
          "cut the solid into fewer")
          .parameter("blocks");
  if (s.block >= count)
    throw Error("bad-value", fmt::format("there is no block {} of {}", s.block, count),
                fmt::format("count from 0 to {}, x fastest, z slowest", count - 1))
        .parameter("block");
}

// What makes a local solid's finer levels: a GPU, Mesa's software renderer, or nothing, which means the
// processor itself.
std::unique_ptr<LocalGl> local_gl(Context& c, const SolidSettings& s) {
  const std::string device = c.text("device");
  if (!s.local && device == "gl")
    throw Error("bad-value", fmt::format("method {} has no shaders", c.text("method")),
                "set method: local, or device: cpu")
        .parameter("device");
  if (!s.local || device == "cpu") return nullptr;
  std::unique_ptr<LocalGl> gl;
  try {
    gl = std::make_unique<LocalGl>(GlDevice::Gpu);
  } catch (const Error& e) {
    if (device == "auto") {
      c.warn("made on the CPU: " + e.diagnostic().message);
      return nullptr;
    }
    if (e.diagnostic().code != "no-gl") throw;
    gl = std::make_unique<LocalGl>(GlDevice::Cpu);
  }
  c.warn("made by OpenGL on " + gl->renderer());
  return gl;
}

// Rows upwards, the first section.
template <class Use>
void each_upwards(int width, int height, Use&& use) {
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x) use(x, y);
}

SolidExemplar exemplar_of(Context& c, const char* port, int which) {
  const Image& image = c.input<Image>(port);
  if (image.width < 16 || image.height < 16)
    throw Error("exemplar-too-small", fmt::format("{} has {} × {} pixels", port, image.width, image.height),
                "take 16 × 16 at least: patches have 8 × 8");
  if (image.sections > 1) c.warn(fmt::format("{} has {} sections: the first is used", port, image.sections));
  SolidExemplar e;
  e.width = image.width, e.height = image.height;
  each_upwards(e.width, e.height, [&](int x, int y) {
    const Vec3f& p = image.at(x, y);
    if (!p.allFinite())
      throw Error("bad-pixels", fmt::format("{} is NaN or infinite at ({}, {})", port, x, y),
                  "mend the picture");
    e.pixels.push_back(p);
  });
  const auto fits = [&](const char* what, int width, int height) {
    if (width != e.width || height != e.height)
      throw Error("size-mismatch",
                  fmt::format("{} {} has {} × {} pixels, {} has {} × {}", what, which + 1, width, height,
                              port, e.width, e.height),
                  "take pictures of one size");
  };
  const auto& masks = c.list("masks");
  if (which < static_cast<int>(masks.size())) {
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
  if (which < static_cast<int>(features.size())) {
    const Image& f = features[which].as<Image>();
    fits("features", f.width, f.height);
    each_upwards(e.width, e.height, [&](int x, int y) { e.features.push_back(f.at(x, y)); });
  }
  return e;
}

// Shrinks so that the shorter side has no more than `most` pixels. Returns the factor ≥ 1 that a pixel grew
// by.
double fit(SolidExemplar& e, int most) {
  const int side = std::min(e.width, e.height);
  if (side <= most) return 1;
  const double by = static_cast<double>(most) / side;
  e = shrink(e, static_cast<int>(std::lround(e.width * by)), static_cast<int>(std::lround(e.height * by)));
  return 1 / by;
}

std::array<int, 3> planes_of(Context& c, const std::vector<SolidExemplar>& exemplars,
                             const std::array<int, 3>& source) {
  std::array<int, 3> plane = {-1, -1, -1};
  if (c.keyword("planes").empty()) {
    for (const auto& name : c.texts("planes")) {
      const auto axis = std::find(std::begin(kAxes), std::end(kAxes), name) - std::begin(kAxes);
      if (axis == 3)
        throw Error("bad-value", fmt::format("'{}' is no axis", name), "planes lie across x, y and z")
            .parameter("planes");
      plane[static_cast<std::size_t>(axis)] = source[static_cast<std::size_t>(axis)];
    }
    if (std::count(plane.begin(), plane.end(), -1) > 1)
      c.warn("with one plane constrained, the slices of a solid have nothing to do with one another");
    return plane;
  }
  // Grain in a plane's picture cannot run the same way on three planes, but on two whose pictures share an
  // axis.
  const double directed = directedness(exemplars[0]);
  c.metric("directedness", directed);
  if (exemplars.size() == 1 && directed > 0.35) {
    c.warn(fmt::format(
        "the exemplar has a direction ({:.2f} of 1), which three planes cannot share: it is seen on planes "
        "across x and y, upright in both; set planes to choose",
        directed));
    return {source[0], source[1], -1};
  }
  return source;
}

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
      row.push_back(b < m.bands.size() ? m.bands[b] : 1.0);
    t.rows.push_back(std::move(row));
  }
  return t;
}

// The value furthest from 1, or largest, of all planes.
template <class Get>
double worst(const std::vector<PlaneMeasures>& measures, Get&& get, double from) {
  double out = from;
  for (const auto& m : measures)
    if (std::abs(get(m) - from) > std::abs(out - from)) out = get(m);
  return out;
}

void compute(Context& c) {
  SolidSettings s;
  s.size = solid_size(c);
  std::vector<SolidExemplar> exemplars;
  std::array<int, 3> source = {0, 0, 0};
  for (int a = 0; a < 3; ++a) {
    if (!c.has(kPorts[a])) continue;
    source[static_cast<std::size_t>(a)] = static_cast<int>(exemplars.size());
    exemplars.push_back(exemplar_of(c, kPorts[a], static_cast<int>(exemplars.size())));
  }
  for (const char* list : {"masks", "features"})
    if (c.list(list).size() > exemplars.size())
      throw Error("too-many-inputs",
                  fmt::format("{} {} for {} exemplars", c.list(list).size(), list, exemplars.size()),
                  "connect one for each exemplar, in their order, or fewer");
  const double pixel = c.input<Image>("exemplar").pixel_size;
  double grown = 1;
  const int most = c.keyword("exemplar_size").empty() ? static_cast<int>(c.integer("exemplar_size"))
                                                      : std::max(64, s.size.maxCoeff());
  for (std::size_t e = 0; e < exemplars.size(); ++e) {
    const double by = fit(exemplars[e], most);
    if (e == 0) grown = by;
  }
  for (std::size_t e = 1; e < exemplars.size(); ++e)
    if (std::min(exemplars[e].width, exemplars[e].height) !=
        std::min(exemplars[0].width, exemplars[0].height))
      c.warn(fmt::format("exemplars of {} × {} and {} × {} pixels: a pixel of either is one voxel",
                         exemplars[0].width, exemplars[0].height, exemplars[e].width, exemplars[e].height));
  s.plane = planes_of(c, exemplars, source);
  s.iterations.clear();
  s.papers = c.text("method") == "papers", s.local = c.text("method") == "local";
  take_blocks(c, s);
  s.local_iterations = c.keyword("iterations").empty() ? 0 : SolidSettings().local_iterations;
  if (!c.keyword("iterations").empty())
    s.iterations = s.papers ? std::vector<int>{100, 20, 10} : std::vector<int>{20, 10, 5};
  else
    for (const auto i : c.ints("iterations")) s.iterations.push_back(static_cast<int>(i));
  s.levels = c.keyword("levels").empty() ? static_cast<int>(c.integer("levels")) : 0;
  s.lab = c.text("color") == "lab";
  s.exponent = c.number("exponent"), s.overuse = c.number("overuse"), s.copying = c.number("copying"),
  s.window = c.number("window");
  s.guide = c.number("guide");
  s.finish = !c.keyword("finish").empty() ? (s.local ? 1 : 2) : static_cast<int>(c.integer("finish"));
  const bool features = !c.list("features").empty(), sources = c.boolean("sources");
  s.sources = features || sources;
  if (s.papers && s.sources)
    throw Error("not-with-papers", "the recipe of 2011 carries no sources or features",
                "take method coherence")
        .parameter("method");
  s.seed = static_cast<std::uint64_t>(c.integer("seed"));

  const double bytes = memory_forecast(exemplars, s);
  if (bytes > c.number("memory") * 1e6)
    throw Error("too-large",
                fmt::format("{} × {} × {} voxels need about {:.0f} MB, more than {:.0f}", s.size.x(),
                            s.size.y(), s.size.z(), bytes / 1e6, c.number("memory")),
                "make the solid smaller (it tiles), or raise memory")
        .parameter("size");
  if (const double coarse = coarseness(exemplars[0]); coarse > 0.7)
    c.warn(fmt::format(
        "{:.0f} % of the exemplar's variance lies in details larger than an eighth of its side: it shows too "
        "few of them to tell how they lie in space",
        100 * coarse));

  SolidResult r;
  {
    const auto gl = local_gl(c, s);
    r = optimize_solid(exemplars, s, c.work().part(0, 0.97), gl.get());
  }

  initialize_openvdb();
  const double voxel = pixel * grown;
  const bool whole = s.blocks == Vec3i::Ones();
  Volume volume;
  volume.resolution = whole ? r.size : Vec3i::Zero().eval();
  const Work last = c.work().part(0.97, 1);
  volume.grids.push_back(dense_grid<openvdb::Vec3SGrid>(
      "Cd", r.size, voxel, last,
      [&](std::size_t i) {
        Vec3f w = Vec3f::Zero();
        for (std::size_t k = 0; k < r.field.channel.size(); ++k)
          w[static_cast<Eigen::Index>(k)] = r.field.channel[k][i];
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
          const auto at = static_cast<int>(r.sources.texel[i]);
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

}  // namespace

NodeType solid_optimize_node() {
  NodeType type =
      NodeType("SolidOptimize", 7)
          .doc_(
              "Synthesises a tileable solid texture whose slices look like the exemplars: wood, marble, meat "
              "and other "
              "materials without particles")
          .source_(
              "Kopf et al. 2007; Laursen, Ersbøll, Bærentzen 2011; search by coherence after Tong et al. "
              "2002 and "
              "Barnes et al. 2009")
          .input("exemplar", "Image",
                 "what slices look like: those across x, and those across y and z where these have no "
                 "exemplar of their "
                 "own. On x and y a picture's columns run along y and x, its rows upwards along z; on z "
                 "along x and y")
          .optional_input("exemplar_y", {"Image"},
                          "what slices across y look like, a pixel being one voxel as in exemplar")
          .optional_input("exemplar_z", {"Image"}, "what slices across z look like")
          .input_list(
              "masks", {"Labels", "Image"},
              "where each exemplar may be used, in their order: labels other than 0, or brighter than 0.2")
          .input_list("features", {"Image"},
                      "three further values for each pixel of each exemplar (height, roughness, a distance), "
                      "carried along "
                      "with its colours")
          .output("volume", "Volume",
                  "grid Cd, scene-linear, one voxel a pixel, periodic; with features the grid features; with "
                  "sources the "
                  "grid source: column and row (from the top) in the exemplar as synthesised, and its number")
          .output("table", "Table", "how near the slices across each constrained axis are to their exemplar")
          .parameter(Parameter::ints("size", {128})
                         .count(1, 3)
                         .range(16, 4096)
                         .unit_("voxels")
                         .doc_("Edge, or one for each axis"))
          .parameter(
              Parameter::with_keyword(ParameterKind::Int, "exemplar_size", "auto")
                  .range(16, 4096)
                  .unit_("pixels")
                  .doc_(
                      "Shorter side to which larger exemplars are reduced before synthesis; voxels grow with "
                      "their pixels. auto: the solid's longest edge, 64 at least"))
          .parameter(Parameter::with_keyword(ParameterKind::Ints, "iterations", "auto")
                         .count(1, 8)
                         .range(1, 1000)
                         .doc_("Of each level, from the coarsest on; the last number counts for all further "
                               "levels. auto: "
                               "20, 10, 5, and 2 of those that are made locally; with papers 100, 20, 10"))
          .parameter(
              Parameter::choice("method", "coherence", {"coherence", "local", "papers"})
                  .doc_(
                      "coherence: neighbours' matches, similar patches and random ones are tried, rare ones "
                      "preferred. local: the finer levels by passes that know of a voxel's surroundings "
                      "alone, so that they can be made in blocks and on a GPU. papers: the recipe of 2011, "
                      "for "
                      "comparison; 128³ takes minutes"))
          .parameter(
              Parameter::ints("blocks", {1})
                  .count(1, 3)
                  .range(1, 256)
                  .doc_("Into how many a local solid is cut, along all axes or each: what is larger than "
                        "memory is made one block a run"))
          .parameter(Parameter::integer("block", 0)
                         .range(0, 16777215)
                         .doc_("The one to make, from 0, x fastest and z slowest: the same voxels as of the "
                               "whole, at their place in it"))
          .parameter(
              Parameter::choice("device", "cpu", {"cpu", "auto", "gl"})
                  .doc_(
                      "Of method local. cpu: the same bits everywhere; gl: OpenGL, on a GPU, else by Mesa's "
                      "software renderer; auto: a GPU where there is one, else cpu. A warning says which it "
                      "was; who shares a cache between machines should not write auto, since rounding "
                      "differs"))
          .parameter(Parameter::with_keyword(ParameterKind::Texts, "planes", "auto")
                         .count(1, 3)
                         .doc_("Axes across which slices look like an exemplar: [x, y, z] or fewer. auto: "
                               "all three, or x "
                               "and y where a single exemplar has a direction"))
          .parameter(Parameter::with_keyword(ParameterKind::Int, "levels", "auto")
                         .range(1, 8)
                         .doc_("Scales, each of half the size of the next. auto: until the exemplar's "
                               "shorter side has 24 "
                               "to 47 pixels"))
          .parameter(Parameter::choice("color", "lab", {"lab", "linear"})
                         .doc_("The colour space of distances and means: Oklab, or scene-linear Rec. 709"))
          .parameter(Parameter::number("exponent", 0.8)
                         .range(0, 2)
                         .doc_("r of the energy ‖patch − match‖^r: below 2 bad matches count less"))
          .parameter(Parameter::number("overuse", 1)
                         .range(0, 100)
                         .doc_("How much further an exemplar patch counts that is in use more often than the "
                               "mean: 0 lets one motif repeat"))
          .parameter(Parameter::number("copying", 1)
                         .range(0, 100)
                         .doc_("How much further an exemplar patch counts that goes on from all four of its "
                               "neighbours as they lie there: 0 lets whole pieces be copied, much more "
                               "breaks them up"))
          .parameter(Parameter::number("guide", 1)
                         .range(0, 10)
                         .doc_("How much the distance to the border between dark and light counts beside "
                               "colours, of which all count 1: keeps veins and joints in one piece. Not with "
                               "papers, and of local the levels that are made whole"))
          .parameter(Parameter::number("window", 0.05)
                         .range(0, 10)
                         .doc_("Of the mean shift at the end of each level, in units of the exemplars' "
                               "standard deviation; "
                               "it starts ten times as wide. 0: plain means, which blur"))
          .parameter(
              Parameter::with_keyword(ParameterKind::Int, "finish", "auto")
                  .range(0, 20)
                  .doc_("Rounds that give the finest bands of all slices the exemplar's distribution "
                        "at the end. auto: 2; with method local 1, of filters that end after 9 voxels"))
          .parameter(Parameter::boolean("sources", false)
                         .doc_("Also give the exemplar's pixel that each voxel comes from"))
          .parameter(Parameter::number("memory", 4000)
                         .range(1, 1e7)
                         .unit_("MB")
                         .doc_("Sizes that need more are refused before any work"))
          .parameter(
              Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of the start and of the search"))
          .compute_(compute);
  for (Port& p : type.inputs) p.optional |= p.many;
  return type;
}

}  // namespace terrazzo
