#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/table.h"
#include "nodes/photograph/segment/segment.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace segment;

void check(const NodeParameters& p) {
  if (p.keyword("binder") == "none" && p.choice<Method>("method") == Method::Clusters)
    throw Error("needs-binder", "method clusters separates particles from a binder, but binder is none",
                "set method to network, scribbles or auto")
        .parameter("binder");
}

Hint hint_of(const Context& c) {
  Hint hint;
  const std::string word = c.keyword("binder");
  if (word == "darkest")
    hint.kind = Hint::Kind::Darkest;
  else if (word == "lightest")
    hint.kind = Hint::Kind::Lightest;
  else if (word == "none")
    hint.kind = Hint::Kind::None;
  else if (word.empty()) {
    const auto rgb = c.numbers("binder");
    hint.kind = Hint::Kind::Color;
    hint.color = patch_color_of_linear(Vec3(rgb[0], rgb[1], rgb[2]).cast<float>());
  }
  return hint;
}

Table binder_table(const Profiles& profiles) {
  Table t;
  t.columns = {"r", "g", "b", "area_fraction", "count"};
  const Vec3f& c = profiles.binder_color;
  t.rows.push_back({static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]),
                    1 - profiles.area_fraction, static_cast<double>(profiles.profiles.size())});
  return t;
}

// Each particle in its confidence's gray, from black to white; the binder is black.
Image confidence_picture(const Image& image, const Segmentation& s) {
  Image out(image.width, image.height, image.sections, image.pixel_size);
  for (std::size_t i = 0; i < s.labels.ids.size(); ++i)
    if (const auto id = s.labels.ids[i]; id > 0)
      out.pixels[i].setConstant(static_cast<float>(s.profiles.profiles[id - 1].confidence));
  return out;
}

// 1: ignored, 2: undecided.
Labels unobserved(const Segmentation& s) {
  Labels out = s.labels;
  out.classes.assign(2, 0);
  for (std::size_t i = 0; i < out.ids.size(); ++i)
    out.ids[i] = !s.ignored.empty() && s.ignored[i] ? 1 : !s.undecided.empty() && s.undecided[i] ? 2 : 0;
  return out;
}

// The size of a pixel according to a ruler or a scale bar, if its unit is known.
std::string scale_of(const FoundObject& o) {
  if (!o.scale) return {};
  const ScaleMark& m = *o.scale;
  if (m.kind == ScaleMark::Kind::Bar)
    return fmt::format(
        ". It has a bar of {:.0f} ± {:.0f} pixels: pixel_size is the bar's length in mm / {:.0f}", m.length,
        m.uncertainty, m.length);
  return fmt::format(
      ". It has marks every {:.2f} ± {:.2f} pixels: if they are millimeters, pixel_size is {:.4g} (± {:.1g} "
      "%)",
      m.length, m.uncertainty, 1 / m.length, 100 * m.uncertainty / m.length);
}

// What was found, where, and what to do about it.
std::string place_of(const FoundObject& o, int sections) {
  const char* what = o.kind == FoundObject::Kind::Caption ? "show a caption"
                     : o.kind == FoundObject::Kind::Ruler ? "show a ruler"
                                                          : "look like a ruler, frame or text";
  return fmt::format(
      "columns {} to {}, rows {} to {}{} {} and are ignored; if they show material, set find_objects to "
      "false, "
      "and use ignore to say what is not material",
      o.left, o.right, o.top, o.bottom, sections > 1 ? fmt::format(" of section {}", o.section) : "", what);
}

SegmentOptions options_of(const Context& c) {
  SegmentOptions options;
  options.clusters = c.optional_integer("clusters").value_or(0);
  options.binder = hint_of(c);
  options.split.strength = c.number("split");
  options.split.min_area = c.optional_number("min_area").value_or(-1);
  options.color_classes = c.optional_integer("color_classes").value_or(0);
  options.method = c.choice<Method>("method");
  options.network_scale = c.optional_number("network_scale").value_or(0);
  options.min_confidence = c.number("min_confidence");
  options.delight = c.text("delight") == "on";
  options.find_objects = c.boolean("find_objects");
  for (const View view : {View::Section, View::Surface, View::Filling})
    if (c.text("view") == name_of(view)) options.view = view;
  options.seed = c.seed();
  options.memory = c.memory();
  return options;
}

void report_method(Context& c, const Segmentation& s) {
  c.metric("clusters", s.ground.clusters.centers.size());
  c.metric("silhouette", s.ground.clusters.silhouette);
  c.metric("min_area", s.min_area);
  c.metric("by_network", s.method == Method::Network || s.method == Method::Both);
  c.metric("by_clusters", s.method == Method::Clusters || s.method == Method::Both);
  if (s.network_scale > 0) c.metric("network_scale", s.network_scale);
  c.metric("by_scribbles", s.method == Method::Scribbles);
  const auto& profiles = s.profiles.profiles;
  const std::size_t uncertain =
      std::count_if(profiles.begin(), profiles.end(), [](const auto& p) { return p.confidence < 0.5; });
  c.metric("uncertain", uncertain);
  c.metric("unlikely_dropped", s.unlikely);
  c.metric("specks_dropped", s.specks);
  c.metric("speck_pixels", s.speck_pixels);
  c.metric("holes_filled", s.holes);
}

void report_reliability(Context& c, const Segmentation& s) {
  c.metric("reliability_of_clusters", s.reliability.clusters);
  c.metric("reliability_of_network", s.reliability.network);
  c.metric("reliability_of_both", s.reliability.both);
  c.metric("distinct_phases", s.distinct_phases);
  if (const double expected = s.method == Method::Clusters ? s.reliability.clusters : s.reliability.both;
      expected < 0.5)
    c.warn("the particles are uncertain: the expected average precision is " +
           fmt::format("{:.2f}", expected) + "; look at the outlines, set min_confidence, or connect labels");
}

// Which view it is, and why.
void report_view(Context& c, const Segmentation& s) {
  const View view = s.profiles.view;
  for (const View one : {View::Section, View::Surface, View::Filling})
    c.metric(fmt::format("view_{}", name_of(one)), view == one);
  c.metric("judged_for_view", s.evidence.judged);
  c.metric("shaded_like_stones", s.evidence.shaded);
  if (view == View::Surface && c.text("view") == "auto")
    c.warn(
        fmt::format("the photograph shows a surface, not a cut: {:.0f} % of {} particles grow lighter from "
                    "the rim to the middle, as whole stones do. Outlines count as whole stones seen from "
                    "outside; if this is a cut, set view to section",
                    100 * s.evidence.shaded, s.evidence.judged));
}

void warn_of_mixed_view(Context& c, const Segmentation& s) {
  const auto mixed = mixed_view(s.evidence);
  if (!mixed || c.text("view") != "auto") return;
  const auto percent = [](const ShadingCount& n) { return 100.0 * n.shaded / n.judged; };
  c.warn(fmt::format(
      "the photograph seems to be part cut and part surface: in its {} half, {:.0f} % of {} particles are "
      "shaded like whole stones, in its {} half {:.0f} % of {}. All of it is taken as a {}; crop it, or set "
      "view",
      mixed->surface, percent(mixed->of_surface), mixed->of_surface.judged, mixed->cut,
      percent(mixed->of_cut), mixed->of_cut.judged, name_of(s.profiles.view)));
}

// A side or corner of the picture, by the direction to it in degrees, 0 to below 360.
const char* place_at(double direction) {
  static constexpr const char* kPlaces[] = {"right", "upper right", "top",    "upper left",
                                            "left",  "lower left",  "bottom", "lower right"};
  return kPlaces[round_nearest(direction / 45) % 8];
}

// Throws Error "tilted-photograph" if the photograph seems to be taken at an angle too large to go on. Beds
// may be sorted by size, so `view: surface` insists.
void report_tilt(Context& c, const TiltEstimate& tilt) {
  // Degrees. Below the first, sizes change by a fifth over the picture, as much as beds do. Beyond the
  // second, they change by half, and stones far away are lost.
  constexpr double kTilted = 8, kTooTilted = 20;
  c.metric("tilt", tilt.degrees);
  if (tilt.degrees < kTilted) return;
  const double set = std::min(60.0, std::round(tilt.degrees));  // at most what LoadImage takes
  const std::string what = fmt::format(
      "in this view of a surface, stones shrink from the {} to the {} by a factor of {:.2f}, as in a "
      "photograph taken at about {:g}° from straight above",
      place_at(std::fmod(tilt.direction + 180, 360)), place_at(tilt.direction), tilt.factor, set);
  const std::string then =
      fmt::format("set tilt of LoadImage to {:g} and tilt_direction to {:g}", set, tilt.direction);
  if (tilt.degrees > kTooTilted && c.text("view") != "surface")
    throw Error("tilted-photograph", what,
                then + ", or take it from above; if the bed itself is sorted by size, set view to surface")
        .parameter("view");
  c.warn(what + "; " + then + ", unless the bed itself is sorted by size");
}

void warn_of_undecided(Context& c, double undecided) {
  constexpr double kMuchUndecided = 0.25;
  if (undecided > kMuchUndecided)
    c.warn(fmt::format(
        "{:.0f} % of the picture show particles that could not be told apart; densities refer to the "
        "rest. Look at output unobserved, draw scribbles, or outline particles with EditLabels",
        100 * undecided));
}

void compute(Context& c) {
  SegmentOptions options = options_of(c);
  const Image& image = c.input<Image>("image");
  const Labels* given = c.optional<Labels>("labels");
  std::optional<Network> network;
  const bool judged = options.method == Method::Auto || options.method == Method::Network;
  if (!given && judged && c.keyword("model").empty()) {
    try {
      options.network = &network.emplace(read_whole(c.files("model").front(), reading_of(c)));
    } catch (Error& e) {
      throw e.parameter("model");
    }
  }
  std::vector<Area> areas;
  if (c.keyword("ignore").empty())
    for (const std::string& text : c.texts("ignore")) areas.push_back(read_area(text));
  options.scribbles = {c.optional<Strokes>("particle_strokes"), c.optional<Strokes>("binder_strokes"),
                       c.optional<Strokes>("not_material_strokes")};
  options.ignored = ignored_pixels(image, areas, c.optional<Labels>("mask"));
  Segmentation s =
      given ? measure_labels(image, *given, options, c.work()) : segment::segment(image, options, c.work());

  std::size_t at_border = 0;
  for (const auto& p : s.profiles.profiles) at_border += p.touches_border;
  c.metric("profiles", s.profiles.profiles.size());
  c.metric("at_border", at_border);
  c.metric("area_fraction", s.profiles.area_fraction);
  const double undecided =
      static_cast<double>(std::count(s.undecided.begin(), s.undecided.end(), 1)) / s.labels.ids.size();
  c.metric("undecided", undecided);
  if (!given) report_method(c, s);
  if (!given && options.method == Method::Auto && s.reliability.both > 0) report_reliability(c, s);
  report_view(c, s);
  warn_of_mixed_view(c, s);
  report_tilt(c, s.tilt);
  warn_of_undecided(c, undecided);
  if (at_border == s.profiles.profiles.size())
    c.warn("all profiles touch the border of the image: none has a weight, so they cannot be unfolded");
  for (const FoundObject& o : s.not_material) c.warn(place_of(o, image.sections) + scale_of(o));
  c.output("delit", s.delit.pixels.empty() ? image : std::move(s.delit));
  c.output("confidence", confidence_picture(image, s));
  c.output("unobserved", unobserved(s));
  c.output("binder", binder_table(s.profiles));
  c.output("labels", std::move(s.labels));
  c.output("profiles", std::move(s.profiles));
}

}  // namespace

namespace {

// What color decides, and how large particles are.
void add_color_parameters(NodeType& type) {
  type.parameter(
          Parameter::optional_integer("clusters", "auto")
              .range(2, 12)
              .doc_("Number of color clusters. auto: the largest number of clearly separate clusters."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Color, "binder", "auto")
              .keyword("darkest")
              .keyword("lightest")
              .keyword("none")
              .doc_("Color of the binder. darkest, lightest: the cluster that is the binder. auto: "
                    "the binder that leaves the most convex particles. none: there is no binder, as in "
                    "granite and metals; the particles that the network or scribbles find grow until "
                    "they meet. The network then recognizes no rulers and text; use ignore."))
      .parameter(Parameter::number("split", 0.5)
                     .range(0, 1)
                     .doc_("Strength of splitting touching particles. 0: never. 1: at every neck."))
      .parameter(Parameter::optional_number("min_area", "auto")
                     .unit_("pixels")
                     .range(0, 1e9)
                     .doc_("Minimum particle size. Smaller particles are dropped and counted. auto: 12, up "
                           "to 48 if pits and noise are frequent; 25 for the network, in the pixels that "
                           "it sees (network_scale)."))
      .parameter(Parameter::integer("color_classes", 1)
                     .keyword("auto")
                     .range(1, 32)
                     .doc_("Number of profile classes by color (k-means), the most frequent class "
                           "first. auto: as many as the colors show and the profiles bear out by different "
                           "sizes or circularities, 1 to 8."));
}

// Who finds particles.
void add_method_parameters(NodeType& type) {
  type.parameter(
          Parameter::choice("method", "auto", {"auto", "clusters", "network", "scribbles"})
              .word_was("regions", "network")
              .doc_("clusters: separates particles from binder by color. network: finds them with a network "
                    "that was "
                    "trained on synthetic photographs. scribbles: learns from the strokes that are "
                    "connected. auto: "
                    "scribbles if there are strokes; otherwise runs clusters and network, joins the better "
                    "of both at "
                    "every place where the colors of the phases are distinct, and takes the clusters alone "
                    "unless another result "
                    "can be expected to be better. The metrics that start with reliability tell why."))
      .parameter(
          Parameter::with_keyword(ParameterKind::InputPath, "model", "built_in")
              .doc_("Network of method network, an ONNX file; see training/README.md for its inputs and "
                    "outputs. built_in: "
                    "the one that comes with the program."))
      .parameter(Parameter::optional_number("network_scale", "auto")
                     .range(0.05, 1)
                     .doc_("Reduction of the picture before the network sees it. Try 0.5 if large particles "
                           "are found in pieces. auto: 1 for sharp pictures, less for pictures that are out "
                           "of focus or were enlarged."))
      .parameter(Parameter::number("min_confidence", 0)
                     .range(0, 1)
                     .doc_("Particles with a lower confidence are dropped. Particles of clusters have a "
                           "confidence of 1 unless method auto judges them."));
}

// What is measured.
void add_measuring_parameters(NodeType& type) {
  type.parameter(
          Parameter::with_keyword(ParameterKind::Texts, "ignore", "none")
              .unit_("pixels")
              .doc_(
                  "Areas that show no material: \"x0 y0 x1 y1\", a rectangle, or \"x0 y0 x1 y1 x2 y2 …\", a "
                  "polygon, from the upper left corner, y down. They are not observed: densities refer to "
                  "the "
                  "rest, and profiles that they cut have no weight."))
      .parameter(
          Parameter::boolean("find_objects", true)
              .doc_(
                  "Ignores captions, text, scale bars and rulers that are found, and what the network takes "
                  "for a ruler, frame or text; warnings name their places. false: only ignore, mask and "
                  "not_material_strokes say what shows no material."))
      .parameter(
          Parameter::choice("delight", "off", {"on", "off"})
              .word_was("auto", "off")
              .doc_("Removes uneven light, gloss and the shading of rounded particles before colors are "
                    "measured; see output delit. Use it for colors that will be lit again, as by a renderer. "
                    "off: colors as photographed, which a section beside the photograph needs."))
      .parameter(
          Parameter::choice("view", "auto", {"auto", "section", "surface", "filling"})
              .doc_("What the photograph shows. section: a plane cut through particles in a binder. surface: "
                    "whole stones from outside, such as a beach, a gravel bed or a bank: outlines are "
                    "silhouettes that hide each other. filling: a cut through grains without a binder. auto: "
                    "surface if particles are shaded like stones, filling if they cover at least 0.97 of the "
                    "picture or there is no binder, else section; the metrics tell why. If surface is set, a "
                    "photograph that seems to be taken at more than 20 degrees from above is no error but a "
                    "warning."))
      .parameter(Parameter::seed().doc_("Random seed of k-means"));
}

}  // namespace

NodeType segment_node() {
  NodeType type =
      NodeType("Segment", 21)
          .doc_(
              "Finds the particles of a section in its photograph and measures each profile: divides the "
              "image "
              "into patches of uniform color, decides which of them are binder, and splits touching "
              "particles.")
          .source_(
              "Profiles as needed by Jagnow, Dorsey, Rushmeier 2004, who outlined them by hand; methods: see "
              "README")
          .input("image", "Image", "Photograph, or a stack of section photographs")
          .optional_input("labels", {"Labels"}, "Labels to measure instead of segmenting the image")
          .optional_input("mask", {"Labels"},
                          "Not 0: pixels that show no material, such as a ruler or a frame")
          .optional_input("particle_strokes", {"Strokes"},
                          "Strokes on particles of the first section, for method scribbles")
          .optional_input("binder_strokes", {"Strokes"}, "Strokes on the binder of the first section")
          .optional_input("not_material_strokes", {"Strokes"},
                          "Strokes on what is not material in the first section")
          .output("labels", "Labels", "Particle number of each pixel; 0: binder")
          .output("profiles", "Profiles", "One profile per particle, with its outline")
          .output("binder", "Table",
                  "One row: r, g, b of the binder (scene-linear), its area_fraction, and count of profiles")
          .output("delit", "Image",
                  "The picture that colors are measured in: the photograph, without its light if `delight` "
                  "says so")
          .output("confidence", "Image", "Confidence of each particle as gray; binder is black")
          .output("unobserved", "Labels",
                  "Pixels that are neither a particle nor surely binder. 1: ignored. 2: undecided, where the "
                  "network "
                  "sees particles that it cannot tell apart, or min_confidence dropped one");
  add_color_parameters(type);
  add_method_parameters(type);
  add_measuring_parameters(type);
  return type.check_(check).compute_(compute);
}

}  // namespace terrazzo
