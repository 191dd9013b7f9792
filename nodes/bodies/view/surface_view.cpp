#include "nodes/bodies/view/surface_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/bodies/carving/particle_colors.h"
#include "nodes/bodies/view/painter.h"
#include "nodes/bodies/view/pieces.h"
#include "nodes/bodies/view/shader.h"
#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

constexpr double kMostPixels = 64 << 20;
constexpr double kReach = 3;            // of the sky's rays, in diameters of the largest particle
constexpr double kLift = 0.05;          // of rays from their surface, pixels
constexpr float kMostReflected = 0.8f;  // by stones: beyond it, light never ends

void require_few_pixels(const SurfaceOptions& options) {
  const double pictures = options.places.size();
  const double pixels = pictures * pixels_in(options.pixels_x, options.pixels_y);
  if (pixels <= kMostPixels) return;
  throw Error("too-many-pixels",
              fmt::format("{} pictures of {} × {} pixels exceed the limit of 64 megapixels for stones seen "
                          "from above",
                          pictures, options.pixels_x, options.pixels_y),
              "use fewer pictures, or raise pixel_size")
      .parameter(pictures > 1 ? "pictures" : "pixel_size");
}

float mean_color(const Particles& particles) {
  double sum = 0;
  std::size_t stones = 0;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    sum += particles.color[i].cwiseMax(0.0f).cwiseMin(1.0f).mean();
    ++stones;
  }
  return static_cast<float>(sum / std::max<std::size_t>(1, stones));
}

SurfaceView empty_view(const Particles& particles, const SurfaceOptions& options) {
  const int pictures = count_of(options.places);
  SurfaceView out;
  out.image = Image(options.pixels_x, options.pixels_y, pictures, options.pixel_size);
  out.labels.width = options.pixels_x;
  out.labels.height = options.pixels_y;
  out.labels.sections = pictures;
  out.labels.pixel_size = options.pixel_size;
  out.labels.ids.assign(out.image.pixels.size(), 0);
  out.profiles.sections = pictures;
  out.profiles.window = {options.width, options.height};
  out.profiles.observed_area = options.width * options.height * pictures;
  out.profiles.binder_color = particles.binder_color;
  out.profiles.view = View::Surface;
  out.profiles.light = options.light.slope;
  out.table.columns = {"section", "particle", "class", "area mm²", "perimeter mm", "whole mm²", "weight"};
  return out;
}

void count_stones(SurfaceView& out, const std::vector<std::int32_t>& stone, const Bed& bed) {
  std::vector<std::uint8_t> visible(bed.count(), 0);
  for (const std::int32_t s : stone) {
    if (s < 0) continue;
    visible[s] = 1;
    ++out.covered;
  }
  out.stones += std::count(visible.begin(), visible.end(), 1);
}

}  // namespace

SurfaceView show_surface(const Particles& particles, const Shapes& shapes, const SurfaceOptions& options,
                         const residual::ResidualField* detail, const residual::Skins* skins,
                         const Work& work) {
  require_few_pixels(options);
  const StoneMeshes meshes(shapes);
  const carving::ParticleColors colors(particles, detail, skins);
  const double reach = kReach * meshes.largest(particles);
  const float albedo = std::min(kMostReflected, mean_color(particles));
  SurfaceView out = empty_view(particles, options);
  const int pictures = count_of(options.places);
  std::optional<BedSoil> soil;
  if (!options.loose && options.area_fraction && !has_top(particles, shapes))
    soil = {options.pixel_size, *options.area_fraction};
  for (int k = 0; k < pictures; ++k) {
    work.check();
    const Work part = work.part(double(k) / pictures, double(k + 1) / pictures);
    // Stones within reach around the picture hide about as much of the sky at its border as within.
    const Bed bed(particles, meshes, options.places[k], {options.width, options.height}, reach,
                  soil ? &*soil : nullptr, part.part(0, 0.2));
    const Shader shader(bed, options.light, reach, kLift * options.pixel_size);
    Painter painter(bed, shader, colors, options, albedo, k);
    painter.paint(&out.image.at(0, 0, k), part.part(0.2, 1));
    count_stones(out, painter.stones(), bed);
    add_pieces(out, k, painter.stones(), bed, particles, options);
  }
  out.profiles.area_fraction = static_cast<double>(out.covered) / out.image.pixels.size();
  return out;
}

}  // namespace terrazzo::view
