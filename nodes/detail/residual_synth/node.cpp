#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/detail/residual_synth/radial.h"
#include "nodes/detail/residual_synth/residual_image.h"
#include "nodes/detail/residual_synth/synthesize.h"
#include "runtime/context.h"

namespace terrazzo::residual_synth {
namespace {

enum class Method { Slices, Radial };

constexpr double kSpecks = 6;  // `specks` of pictures with labels

Vec3i volume_size(const NodeParameters& c) {
  const Vec3i size = one_or_three(c, "size");
  if (size.cast<double>().prod() > 5.4e8)
    throw Error("too-large", fmt::format("{} × {} × {} voxels are too many", size.x(), size.y(), size.z()),
                "use at most 800³ voxels: the volume tiles")
        .parameter("size");
  return size;
}

// Converts encoded colors to scene-linear ones, clipped to the display's range.
Vec3f to_linear(const Vec3f& encoded) { return srgb_to_linear(encoded.cwiseMax(0.0f).cwiseMin(1.0f)); }

// Outputs the pictures of figure 6 of the 2004 paper: mean colors, and the residual around the binder's
// color.
void output_pictures(Context& c, const ResidualImage& residual) {
  Image means = residual.means, about = residual.image;
  for (auto& p : means.pixels) p = to_linear(p);
  for (auto& p : about.pixels) p = to_linear(residual.binder + p);
  c.output("means", std::move(means));
  c.output("residual", std::move(about));
}

struct Measured {
  std::vector<Image> residuals;
  std::array<int, 3> picture = {0, 0, 0};  // index for slices across x, y and z
  double filled = 0, specks = 0;           // means over the pictures
  Vec3f binder = Vec3f::Zero();            // of `image`, encoded
};

Measured measure_pictures(Context& c) {
  constexpr std::array<const char*, 3> kSuffix = {"", "_y", "_z"};
  Measured out;
  const int edge = c.integer("edge");
  for (int a = 0; a < 3; ++a) {
    const std::string image_port = std::string("image") + kSuffix[a],
                      labels_port = std::string("labels") + kSuffix[a];
    if (!c.has(image_port)) {
      if (c.has(labels_port))
        throw Error("missing-input", fmt::format("{} is connected, but {} is not", labels_port, image_port),
                    "connect the picture that the labels belong to");
      continue;
    }
    const auto& image = c.input<Image>(image_port);
    const double first = c.input<Image>("image").pixel_size;
    if (std::abs(image.pixel_size - first) > 1e-6 * first)
      throw Error("size-mismatch",
                  fmt::format("a pixel of {} is {} mm wide, a pixel of image {} mm", image_port,
                              image.pixel_size, first),
                  "use pictures with the same pixel size");
    Labels none;
    none.width = image.width;
    none.height = image.height;
    none.sections = image.sections;
    none.pixel_size = image.pixel_size;
    const bool labeled = c.has(labels_port);
    if (!labeled) none.ids.assign(image.pixels.size(), 0);
    const double specks = c.optional_number("specks").value_or(labeled ? kSpecks : 0);
    const ResidualImage residual = residual_image(as_displayed(image, c.work().part(0, 0)),
                                                  labeled ? c.input<Labels>(labels_port) : none, edge, specks,
                                                  c.work().part(0.01, 0.05));
    if (residual.edge < edge)
      c.warn(
          fmt::format("{}: the band left out around outlines is {} pixels instead of {}, because too little "
                      "else would be left",
                      image_port, residual.edge, edge));
    if (a == 0) {
      output_pictures(c, residual);
      out.binder = residual.binder;
    }
    out.picture[a] = out.residuals.size();
    out.residuals.push_back(residual.image);
    out.filled += residual.filled;
    out.specks += residual.specks;
  }
  out.filled /= out.residuals.size();
  out.specks /= out.residuals.size();
  return out;
}

void check(const NodeParameters& p) { volume_size(p); }

void compute(Context& c) {
  const auto& image = c.input<Image>("image");
  const Vec3i size = volume_size(c);
  const Work& work = c.work();
  const bool radial = c.choice<Method>("method") == Method::Radial;
  if (radial && (c.has("image_y") || c.has("image_z")))
    throw Error("bad-value", "method radial cannot use a picture per axis",
                "set method: slices, or disconnect image_y and image_z")
        .parameter("method");
  const Measured measured = measure_pictures(c);
  int shortest = size.minCoeff();
  for (const Image& r : measured.residuals) shortest = std::min({shortest, r.width, r.height});
  const Exemplar exemplar = measure_exemplar(measured.residuals, measured.picture, pyramid_scales(shortest),
                                             radial ? 1 : 4, work.part(0.05, 0.15));
  if (exemplar.channels == 0)
    c.warn("the photograph shows nothing beyond its profiles' mean colors, so the residual is zero");
  const int rounds = c.integer("rounds");
  const auto seed = c.seed();
  const auto voxels = radial ? synthesize_radial(exemplar, size, rounds, seed, work.part(0.15, 0.9))
                             : synthesize_residual(exemplar, size, rounds, seed, work.part(0.15, 0.9));
  const Exemplar told = radial ? measure_exemplar(measured.residuals, measured.picture, exemplar.scales, 4,
                                                  work.part(0.9, 0.92))
                               : exemplar;
  const auto deviation = slice_deviations(told, size, voxels, work.part(0.92, 0.95));

  Volume volume;
  volume.resolution = size;
  add_vector_grid(volume, "residual", size, image.pixel_size, work.part(0.95, 1),
                  [&](std::size_t i) { return voxels[i]; });
  if (c.boolean("preview"))
    add_vector_grid(volume, "Cd", size, image.pixel_size, work.part(0.99, 1),
                    [&](std::size_t i) { return to_linear(measured.binder + voxels[i]); });
  c.metric("filled", measured.filled);
  c.metric("specks", measured.specks);
  c.metric("deviation", exemplar.channels > 0 ? exemplar.values[0].deviation : 0);
  for (std::size_t s = 0; s < deviation.size(); ++s)
    c.metric(s == 0                      ? "band_high"
             : s + 1 == deviation.size() ? "band_low"
                                         : fmt::format("band_{}", s),
             deviation[s]);
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::residual_synth

namespace terrazzo {

NodeType residual_synth_node() {
  using namespace residual_synth;
  return NodeType("ResidualSynth", 6)
      .doc_(
          "Synthesizes a tileable solid of the fine detail that a photograph shows within particles and "
          "binder, at the photograph's scale")
      .source_("Heeger, Bergen 1995; Jagnow, Dorsey, Rushmeier 2004, section 4.3; Moisan 2011")
      .input("image", "Image", "Photograph with one or more sections")
      .optional_input("labels", {"Labels"},
                      "Profiles of image. Without them, the photograph is treated as binder only.")
      .optional_input(
          "image_y", {"Image"},
          "Photograph for slices across y, if different from image; image then serves the other axes. On x "
          "and y columns run along y and x and rows upwards along z; on z they run along x and y.")
      .optional_input("labels_y", {"Labels"},
                      "Profiles of image_y. Without them, image_y is treated as binder only.")
      .optional_input("image_z", {"Image"}, "Photograph for slices across z")
      .optional_input("labels_z", {"Labels"},
                      "Profiles of image_z. Without them, image_z is treated as binder only.")
      .output("volume", "Volume",
              "Grid residual: offsets of mean 0 to the sRGB-encoded color, one voxel per pixel, periodic. "
              "With preview also Cd.")
      .output("means", "Image", "Mean color of each pixel's profile, as in figure 6b of the 2004 paper")
      .output("residual", "Image",
              "Image minus means, plus the binder's mean color, as in figure 6c of the 2004 paper")
      .parameter(Parameter::ints("size", {128})
                     .count(1, 3)
                     .range(16, 2048)
                     .unit_("voxels")
                     .doc_("Edge length, or one length per axis. Multiples of 16 and products of 2, 3 and 5 "
                           "are fastest."))
      .parameter(Parameter::seed())
      .parameter(Parameter::choice("method", "slices", {"slices", "radial"})
                     .doc_("slices: matches a steerable pyramid on all slices across each axis to the "
                           "photograph's. radial: matches bands of the volume itself, as in the 2004 paper, "
                           "for comparison; its slices have the wrong bands."))
      .parameter(Parameter::integer("rounds", 2)
                     .range(0, 100)
                     .doc_("Rounds of matching all bands to the photograph's distributions, each followed by "
                           "filters that correct their deviations. 0 leaves Gaussian noise with the "
                           "photograph's spectrum and values."))
      .parameter(Parameter::integer("edge", 2).range(0, 32).unit_("pixels").doc_(
          "Width of the band on each side of outlines that is filled from beyond instead of used"))
      .parameter(
          Parameter::optional_number("specks", "auto")
              .range(0, 1e6)
              .doc_("Limit in robust standard deviations from the binder's median. Binder pixels beyond it "
                    "are particles missed by the labels and are filled like outlines. 0 keeps them. auto: 6 "
                    "for a picture with labels, 0 for one without."))
      .parameter(Parameter::boolean("preview", false)
                     .doc_("Also writes the grid Cd for viewing: the residual plus the binder's mean color"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
