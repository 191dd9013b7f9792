#include "nodes/photograph/segment/scribbles/propose.h"

#include <algorithm>

namespace terrazzo::segment {
namespace {

// How clearly the trees agree on each particle: 0 where half of them say particle, 1 where all do.
std::vector<double> agreement(const ScribbleMaps& maps, const std::vector<std::int32_t>& labels) {
  const std::int32_t count = *std::max_element(labels.begin(), labels.end());
  std::vector<double> sum(count, 0), pixels(count, 0);
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const auto id = labels[k];
    if (id == 0) continue;
    sum[id - 1] += std::max(0.0f, 2 * maps.particle[k] - 1);
    ++pixels[id - 1];
  }
  for (std::int32_t k = 0; k < count; ++k) sum[k] /= std::max(1.0, pixels[k]);
  return sum;
}

}  // namespace

Proposal propose_by_scribbles(const Image& image, const SegmentOptions& options, IgnoredPixels& ignored,
                              const Work& work) {
  const ScribbleForest forest(image, 0, options.scribbles, options.seed, work.part(0, 0.25));
  Proposal proposal;
  for (int i = 0; i < image.sections; ++i) {
    const double sections = image.sections;
    const ScribbleMaps maps =
        forest.classify(image, i, work.part(0.25 + 0.75 * i / sections, 0.25 + 0.75 * (i + 1) / sections));
    Particles2D bodies =
        find_particles_by_scribbles(maps, image.width, image.height, options.split, work.quiet());
    if (options.scribbles.not_material) {
      ignored.resize(image.pixels.size(), 0);
      for (std::size_t k = 0; k < maps.not_material.size(); ++k)
        if (maps.not_material[k] > 0.5f) ignored[image.index(0, 0, i) + k] = 1;
    }
    const std::vector<double> confidence = agreement(maps, bodies.labels);
    proposal.add(std::move(bodies), confidence);
  }
  return proposal;
}

}  // namespace terrazzo::segment
