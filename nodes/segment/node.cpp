#include "graph/node_type.h"
#include "nodes/data/table.h"
#include "nodes/segment/segment.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace segment;

Hint hint_of(const Context& c) {
  Hint hint;
  const std::string word = c.keyword("binder");
  if (word == "darkest")
    hint.kind = Hint::Kind::Darkest;
  else if (word == "lightest")
    hint.kind = Hint::Kind::Lightest;
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

void compute(Context& c) {
  SegmentOptions options;
  options.clusters = static_cast<int>(c.optional_integer("clusters").value_or(0));
  options.binder = hint_of(c);
  options.split.strength = c.number("split");
  options.split.min_area = c.optional_number("min_area").value_or(-1);
  options.color_classes = static_cast<int>(c.optional_integer("color_classes").value_or(0));
  const std::string method = c.text("method");
  options.method = method == "clusters"  ? Method::Clusters
                   : method == "regions" ? Method::Regions
                                         : Method::Auto;
  options.seed = c.seed();

  const Image& image = c.input<Image>("image");
  const Labels* given = c.optional<Labels>("labels");
  Segmentation s =
      given ? measure_labels(image, *given, options, c.work()) : segment::segment(image, options, c.work());

  std::size_t at_border = 0;
  for (const auto& p : s.profiles.profiles) at_border += p.touches_border;
  c.metric("profiles", static_cast<double>(s.profiles.profiles.size()));
  c.metric("at_border", static_cast<double>(at_border));
  c.metric("area_fraction", s.profiles.area_fraction);
  if (!given) {
    c.metric("by_regions", s.method == Method::Regions);
    c.metric("clusters", static_cast<double>(s.ground.clusters.centers.size()));
    c.metric("silhouette", s.ground.clusters.silhouette);
    c.metric("min_area", s.min_area);
    c.metric("specks_dropped", static_cast<double>(s.specks));
    c.metric("speck_pixels", static_cast<double>(s.speck_pixels));
    c.metric("holes_filled", static_cast<double>(s.holes));
  }
  if (!given && method == "auto" && s.method == Method::Regions)
    c.warn(
        "the colors differ too little compared with the texture: particles were found by edge and shape, and "
        "some were missed; connect labels if that matters");
  if (at_border == s.profiles.profiles.size())
    c.warn("all profiles touch the border of the image: none has a weight, so they cannot be unfolded");
  c.output("binder", binder_table(s.profiles));
  c.output("labels", std::move(s.labels));
  c.output("profiles", std::move(s.profiles));
}

}  // namespace

NodeType segment_node() {
  return NodeType("Segment", 2)
      .doc_(
          "Finds the particles of a section in its photograph and measures each profile: divides the image "
          "into patches of uniform color, decides which of them are binder, and splits touching particles.")
      .source_(
          "Profiles as needed by Jagnow, Dorsey, Rushmeier 2004, who outlined them by hand; methods: see "
          "README")
      .input("image", "Image", "Photograph, or a stack of section photographs")
      .optional_input("labels", {"Labels"}, "Labels to measure instead of segmenting the image")
      .output("labels", "Labels", "Particle number of each pixel; 0: binder")
      .output("profiles", "Profiles", "One profile per particle, with its outline")
      .output("binder", "Table",
              "One row: r, g, b of the binder (scene-linear), its area_fraction, and count of profiles")
      .parameter(
          Parameter::optional_integer("clusters", "auto")
              .range(2, 12)
              .doc_("Number of color clusters. auto: the largest number of clearly separate clusters."))
      .parameter(Parameter::with_keyword(ParameterKind::Color, "binder", "auto")
                     .keyword("darkest")
                     .keyword("lightest")
                     .doc_("Color of the binder. darkest, lightest: the cluster that is the binder. auto: "
                           "the binder that leaves the most convex particles."))
      .parameter(Parameter::number("split", 0.5)
                     .range(0, 1)
                     .doc_("Strength of splitting touching particles. 0: never. 1: at every neck."))
      .parameter(Parameter::optional_number("min_area", "auto")
                     .unit_("pixels")
                     .range(0, 1e9)
                     .doc_("Minimum particle size. Smaller particles are dropped and counted. auto: 12, up "
                           "to 48 if pits and noise are frequent; 25 for method regions."))
      .parameter(Parameter::integer("color_classes", 1)
                     .keyword("auto")
                     .range(1, 32)
                     .doc_("Number of profile classes by mean color (k-means), the most frequent class "
                           "first. auto: 2 to 8, chosen by silhouette."))
      .parameter(Parameter::choice("method", "auto", {"auto", "clusters", "regions"})
                     .doc_("clusters: separates particles from binder by color. regions: finds particles by "
                           "edge and shape, for photographs of rough surfaces. auto: chooses by the ratio of "
                           "color differences to texture."))
      .parameter(Parameter::seed().doc_("Random seed of k-means"))
      .compute_(compute);
}

}  // namespace terrazzo
