#include "nodes/segment/network_particles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terrazzo::segment {

double confidence_of_score(double score) { return 1 / (1 + std::exp(1.97 - 16.41 * score)); }

NetworkView::NetworkView(const Image& image, int section, const Network& network, const Work& work) {
  constexpr std::array<double, 4> scales{1, 0.7, 0.5, 1.4};
  // Below this the network would only see the mirrored margin.
  constexpr double kSmallest = 96;
  std::vector<double> useful;
  for (const double scale : scales)
    if (scale >= 1 || std::min(image.width, image.height) * scale >= kSmallest) useful.push_back(scale);
  scales_ = network(image, section, useful, work);
}

std::vector<Instance> NetworkView::instances(const Work& work) const {
  std::vector<std::vector<Instance>> found(scales_.size());
  work.parallel(scales_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) found[k] = find_instances(scales_[k], work.quiet());
  });
  std::vector<Instance> all;
  for (auto& of_scale : found)
    for (auto& instance : of_scale) all.push_back(std::move(instance));
  return all;
}

NetworkView::Found NetworkView::choose(std::vector<Instance> instances, const NetworkOptions& options,
                                       const Work& work) const {
  const NetworkMaps& own = scales_.front();
  Accepted accepted = accept_instances(std::move(instances), own.width, own.height, options.min_area,
                                       options.min_score, work);
  Found found;
  found.scores = std::move(accepted.scores), found.from = std::move(accepted.from);
  Particles2D& out = found.particles;
  out.min_area = options.min_area;
  out.labels = std::move(accepted.labels);
  out.coverage.resize(out.labels.size());
  for (std::size_t i = 0; i < out.labels.size(); ++i)
    out.coverage[i] = out.labels[i] > 0 ? std::max(0.5f, own.inside[i]) : std::min(0.499f, own.inside[i]);
  return found;
}

std::vector<double> NetworkView::scores(const std::vector<std::int32_t>& labels, int count) const {
  std::vector<double> best(count, 0);
  for (const NetworkMaps& maps : scales_) {
    const std::vector<double> scores = score_labels(maps, labels, count);
    for (int k = 0; k < count; ++k) best[k] = std::max(best[k], scores[k]);
  }
  return best;
}

std::vector<std::uint8_t> NetworkView::not_material() const {
  std::vector<std::uint8_t> out;
  for (const float v : scales_.front().not_material) out.push_back(v > 0.5f);
  return out;
}

}  // namespace terrazzo::segment
