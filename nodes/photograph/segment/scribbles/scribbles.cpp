#include "nodes/photograph/segment/scribbles/scribbles.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/split.h"

namespace terrazzo::segment {
namespace {

enum Class { Binder = 0, Particle = 1, NotMaterial = 2 };

PixelForest learned(const Image& image, int section, const Scribbles& scribbles, std::uint64_t seed,
                    const Work& work) {
  const auto taught = [&](Class number, const Strokes* strokes) {
    return TaughtClass{number, stroked_pixels(strokes, image.width, image.height)};
  };
  const std::vector<TaughtClass> classes{taught(Particle, scribbles.particles),
                                         taught(Binder, scribbles.binder),
                                         taught(NotMaterial, scribbles.not_material)};
  for (const Class needed : {Particle, Binder})
    if (classes[needed == Particle ? 0 : 1].pixels.empty())
      throw Error(
          "no-strokes", std::string("no pixel is marked as ") + (needed == Particle ? "particle" : "binder"),
          "connect strokes on particles to particle_strokes and strokes on the binder to binder_strokes");
  return {image, section, classes, seed, work};
}

}  // namespace

ScribbleForest::ScribbleForest(const Image& image, int of_section, const Scribbles& scribbles,
                               std::uint64_t seed, const Work& work)
    : forest_(learned(image, of_section, scribbles, seed, work)) {}

ScribbleMaps ScribbleForest::classify(const Image& image, int section, const Work& work) const {
  auto shares = forest_.classify(image, section, 3, work);
  return {std::move(shares[Particle]), std::move(shares[NotMaterial])};
}

Particles2D find_particles_by_scribbles(const ScribbleMaps& maps, int width, int height,
                                        const SplitOptions& options, const Work& work) {
  // Single pixels change sides; their neighbors know better.
  std::vector<float> share = maps.particle;
  cv::Mat m(height, width, CV_32F, share.data());
  cv::GaussianBlur(m, m, cv::Size(0, 0), 1, 1, cv::BORDER_REFLECT_101);
  Particles2D out;
  out.min_area = options.min_area >= 0 ? options.min_area : 25;
  std::vector<std::int32_t> raster(share.size(), 0);
  for (std::size_t i = 0; i < share.size(); ++i) raster[i] = share[i] > 0.5f && maps.not_material[i] < 0.5f;
  if (options.strength > 0) raster = split_at_necks(raster, width, height, options.strength, work);
  const Components parts = connected_components(raster, width, height, false);
  out.labels = parts.ids;
  for (const auto size : parts.sizes)
    if (size < out.min_area) {
      ++out.specks;
      out.speck_pixels += size;
    }
  for (auto& l : out.labels)
    if (l != 0 && parts.sizes[l - 1] < out.min_area) l = 0;
  renumber_labels(out.labels);
  out.coverage.resize(share.size());
  for (std::size_t i = 0; i < share.size(); ++i)
    out.coverage[i] = out.labels[i] > 0 ? std::max(0.5f, share[i]) : std::min(0.499f, share[i]);
  return out;
}

}  // namespace terrazzo::segment
