#include "nodes/media/annealing/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/data/indices.h"
#include "nodes/media/annealing/comparison.h"
#include "nodes/media/annealing/phase_grid.h"
#include "nodes/media/micrograph/find_phases.h"
#include "nodes/media/micrograph/structure.h"
#include "nodes/media/micrograph/unobserved.h"
#include "runtime/memory.h"

namespace terrazzo::annealing {
namespace {
using media::PhaseMap;

constexpr int kLeastSide = 32;  // pixels
constexpr double kDirected =
    0.35;  // from there on grain cannot run the same way on three planes, as in SolidOptimize
constexpr double kFewStructures = 16;  // correlation lengths along a side of the picture
constexpr const char* kAxes = "xyz";

void mask_out(PhaseMap& map, const Labels& mask, std::size_t number) {
  if (mask.width != map.width || mask.height != map.height)
    throw Error("size-mismatch",
                fmt::format("mask {} has {} × {} pixels, its picture {} × {}", number, mask.width,
                            mask.height, map.width, map.height),
                "connect masks in the order of the pictures");
  for (std::size_t i = 0; i < map.at.size(); ++i)
    if (mask.ids[i] != 0) map.at[i] = media::kUnobserved;
}

PhaseMap of_labels(Context& c, const Labels& labels, const Labels* mask, std::size_t number) {
  if (labels.sections > 1) c.warn("only the first section of labels is used");
  PhaseMap out = media::phase_map(labels);
  if (mask) mask_out(out, *mask, number);
  return out;
}

media::FoundPhases of_image(Context& c, const Image& image, const Labels* mask) {
  if (image.sections > 1) c.warn("only the first section of an image is used");
  require_memory(media::phases_forecast(image), c.memory(), "the phases of the picture");
  const auto unobserved = media::unobserved_pixels(
      image, mask, true,
      [&](const std::string& text) {
        c.warn(text + "; if they show material, connect labels of Phases instead");
      },
      c.work().quiet());
  return media::find_phases(image, unobserved, {}, c.work().quiet());
}

// Of each phase in the picture, black if it shows none of it.
std::vector<Vec3f> mean_colors(const Image& image, const PhaseMap& map) {
  if (image.width != map.width || image.height != map.height)
    throw Error("size-mismatch",
                fmt::format("image 1 has {} × {} pixels, its labels {} × {}", image.width, image.height,
                            map.width, map.height),
                "connect the image that the phases are from, or labels alone");
  std::vector<Vec3> sum(map.phases, Vec3::Zero());
  std::vector<double> count(map.phases, 0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (const auto p = map.at[map.index(x, y)]; p != media::kUnobserved) {
        sum[p] += image.at(x, y).cast<double>();
        ++count[p];
      }
  std::vector<Vec3f> out;
  for (int p = 0; p < map.phases; ++p) out.push_back((sum[p] / std::max(count[p], 1.0)).cast<float>());
  return out;
}

PhaseRequest pictures_of(Context& c) {
  const auto& images = c.list("image");
  const auto& labels = c.list("labels");
  const auto& masks = c.list("masks");
  const std::size_t count = labels.empty() ? images.size() : labels.size();
  if (count == 0)
    throw Error("missing-input", "there is no picture",
                "connect one to three images, or one to three labels of phases");
  if (count > 3 || masks.size() > count || (!labels.empty() && images.size() > 1))
    throw Error(
        "too-many-inputs",
        fmt::format("{} images, {} labels and {} masks", images.size(), labels.size(), masks.size()),
        "connect at most three pictures, and at most one mask for each; beside labels, only the image of "
        "the first");
  PhaseRequest out;
  for (std::size_t k = 0; k < count; ++k) {
    const Labels* mask = k < masks.size() ? &masks[k].as<Labels>() : nullptr;
    if (labels.empty()) {
      auto found = of_image(c, images[k].as<Image>(), mask);
      if (k == 0) out.color = std::move(found.color);
      out.maps.push_back(std::move(found.map));
      continue;
    }
    out.maps.push_back(of_labels(c, labels[k].as<Labels>(), mask, k + 1));
    if (k == 0 && !images.empty()) out.color = mean_colors(images[0].as<Image>(), out.maps[0]);
  }
  return out;
}

void check_pictures(PhaseRequest& pictures) {
  const PhaseMap& first = pictures.maps[0];
  for (std::size_t k = 0; k < pictures.maps.size(); ++k) {
    const PhaseMap& m = pictures.maps[k];
    if (std::min(m.width, m.height) < kLeastSide)
      throw Error("exemplar-too-small",
                  fmt::format("picture {} has {} × {} pixels", k + 1, m.width, m.height),
                  fmt::format("use at least {0} × {0} pixels", kLeastSide));
    const auto shares = fractions_of(m);
    if (std::count_if(shares.begin(), shares.end(), [](double f) { return f > 0; }) < 2)
      throw Error("one-phase", fmt::format("picture {} shows a single phase where it is observed", k + 1),
                  "use a picture that shows at least two");
    if (std::abs(m.pixel_size / first.pixel_size - 1) > 0.01)
      throw Error("size-mismatch",
                  fmt::format("a pixel of picture {} is {:.4g} mm, one of picture 1 {:.4g} mm", k + 1,
                              m.pixel_size, first.pixel_size),
                  "scale the pictures so that their pixels are equal, since a pixel is a voxel");
    if (m.phases != first.phases)
      throw Error("phases-differ",
                  fmt::format("picture {} has {} phases, picture 1 has {}", k + 1, m.phases, first.phases),
                  "use pictures with the same phases, or set phases of Phases");
  }
  for (int p = count_of(pictures.color); p < first.phases; ++p)
    pictures.color.push_back(Vec3f::Constant(0.05f + 0.85f * static_cast<float>(p) / (first.phases - 1)));
}

// One picture for all planes, two for x and y and for z, three for x, y and z.
AnnealOptions options_of(Context& c, const std::vector<PhaseMap>& maps) {
  AnnealOptions out;
  out.size = one_or_three(c, "size");
  out.seed = c.seed();
  const int last = count_of(maps) - 1;
  out.plane = {0, std::max(0, last - 1), last};
  const double directed = media::directedness(maps[0]);
  c.metric("directedness", directed);
  const bool automatic = !c.keyword("planes").empty();
  if (!automatic) {
    const auto names = c.texts("planes");
    for (const auto& name : names)
      if (name.size() != 1 || std::string(kAxes).find(name) == std::string::npos)
        throw Error("bad-value", fmt::format("'{}' is not an axis", name), "choose from x, y and z")
            .parameter("planes");
    for (int a = 0; a < 3; ++a)
      if (std::count(names.begin(), names.end(), std::string(1, kAxes[a])) == 0) out.plane[a] = -1;
    if (std::count(out.plane.begin(), out.plane.end(), -1) > 1)
      c.warn("only one plane is constrained, so successive slices of the solid are unrelated");
  } else if (last == 0 && directed > kDirected) {
    c.warn(
        fmt::format("the picture is directional ({:.2f}, where 1 means stripes), which three planes cannot "
                    "all show: only slices across x and y are matched, upright in both. Set planes to choose "
                    "others.",
                    directed));
    out.plane[2] = -1;
  }
  for (int p = 0; p <= last; ++p)
    if (std::count(out.plane.begin(), out.plane.end(), p) == 0)
      throw Error("bad-value", fmt::format("no plane shows picture {}", p + 1),
                  "leave out the picture, or add its axis to planes")
          .parameter("planes");
  out.turned = last == 0 && directed <= kDirected;
  return out;
}

void warn_of_structures(Context& c, const std::vector<PhaseMap>& maps) {
  double longest = 0;
  for (const PhaseMap& m : maps) {
    const double length = media::correlation_length(m);
    longest = std::max(longest, length);
    if (std::min(m.width, m.height) < kFewStructures * length)
      c.warn(
          fmt::format("the picture shows few structures: its correlation length is {:.1f} pixels, its "
                      "shorter side {}. Their arrangement is uncertain; use a larger picture.",
                      length, std::min(m.width, m.height)));
  }
  c.metric("correlation_length", longest);
}

void give_metrics(Context& c, const Solid& solid, const std::vector<Agreement>& all) {
  double within = 0;
  std::map<std::string, double> worst;
  for (const Agreement& a : all) {
    within += std::abs(a.difference) <= a.scatter;
    double& w = worst[a.measure];
    const bool relative = a.measure == "surface per volume" && a.of_picture[0] > 0;
    w = std::max(w, std::abs(a.difference) / (relative ? a.of_picture[0] : 1));
  }
  c.metric("two_point", worst["two-point correlation"]);
  c.metric("lineal_path", worst["lineal path"]);
  c.metric("cluster", worst["cluster function"]);
  c.metric("surface", worst["surface per volume"]);
  c.metric("within_scatter", within / all.size());
  c.metric("mismatch", solid.levels.back().end);
}

}  // namespace

PhaseRequest read_request(Context& c) {
  PhaseRequest out = pictures_of(c);
  check_pictures(out);
  out.options = options_of(c, out.maps);
  check_voxel(out.maps[0].pixel_size);
  warn_of_structures(c, out.maps);
  return out;
}

void give_agreement(Context& c, const PhaseRequest& request, const Solid& solid, const Work& work) {
  const auto agreement = compare_slices(request.maps, request.options, solid, work);
  give_metrics(c, solid, agreement);
  c.output("figure", agreement_figure(agreement, show(request.maps, request.options, solid)));
  c.output("table", agreement_table(agreement));
}

NodeType& declare_pictures(NodeType& type) {
  type.input_list(
          "image", {"Image"},
          "One to three micrographs, whose phases are found as Phases finds them. One is for all planes, "
          "two are for slices across x and y and across z, three for x, y and z. On x and y a picture's "
          "columns run along y and x and its rows upwards along z; on z they run along x and y.")
      .input_list(
          "labels", {"Labels"},
          "The same as phases: binder is phase 0, profiles of class k are phase k + 1. An image beside "
          "them, that of the first, only gives the colors.")
      .input_list("masks", {"Labels"}, "Pixels to ignore, where labels are not 0, one mask for each picture");
  for (Port& p : type.inputs) p.optional = true;
  return type;
}

NodeType& declare_agreement(NodeType& type) {
  return type
      .output("table", "Table",
              "Each phase's fraction, functions, chords, surface, Euler number and connection in the "
              "pictures "
              "and in slices of the solid. difference: solid less picture, or mean absolute difference of "
              "functions. scatter: the same of the picture's tiles.")
      .output("figure", "Image", "Pictures and slices at one scale, and the functions of each phase");
}

NodeType& declare_settings(NodeType& type, int least_edge) {
  return type
      .parameter(Parameter::ints("size", {128})
                     .count(1, 3)
                     .range(least_edge, 2048)
                     .unit_("voxels")
                     .doc_("Edge length, or one length per axis. A voxel is a pixel."))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "planes", "auto")
                     .count(1, 3)
                     .doc_("Axes across which slices must look like a picture: [x, y, z] or fewer. auto: all "
                           "three, but only x and y if a single picture is directional."))
      .parameter(Parameter::seed());
}

}  // namespace terrazzo::annealing
