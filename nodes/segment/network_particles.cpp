#include "nodes/segment/network_particles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/geometry/components.h"
#include "nodes/segment/instances.h"
#include "nodes/segment/majority.h"

namespace terrazzo::segment {

double confidence_of_score(double score) { return 1 / (1 + std::exp(1.95 - 14.02 * score)); }

namespace {

// A mode filter takes the fringes away; what it cuts off is no part of the particle.
void smooth_outlines(std::vector<std::int32_t>& labels, int width, int height, const Work& work) {
  for (int round = 0; round < 2; ++round) labels = majority(labels, width, height, 1, work);
  const Components parts = connected_components(labels, width, height, false);
  std::vector<std::int32_t> largest(*std::max_element(labels.begin(), labels.end()) + 1, 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (auto& best = largest[labels[i]];
        labels[i] > 0 && (best == 0 || parts.sizes[parts.ids[i] - 1] > parts.sizes[best - 1]))
      best = parts.ids[i];
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] > 0 && parts.ids[i] != largest[labels[i]]) labels[i] = 0;
}

}  // namespace

NetworkView::NetworkView(const Image& image, int section, const Network& network, const Work& work) {
  constexpr std::array<double, 4> scales{1, 0.7, 0.5, 1.4};
  for (std::size_t k = 0; k < scales.size(); ++k) {
    // Below this the network would only see the mirrored margin.
    if (scales[k] < 1 && std::min(image.width, image.height) * scales[k] < 96) continue;
    scales_.push_back(network(image, section, scales[k],
                              work.part(static_cast<double>(k) / scales.size(), (k + 1.0) / scales.size())));
  }
}

NetworkView::Found NetworkView::find_particles(const NetworkOptions& options, const Work& work) const {
  const NetworkMaps& own = scales_.front();
  std::vector<Instance> instances;
  for (const NetworkMaps& maps : scales_)
    for (auto& instance : find_instances(maps, work)) instances.push_back(std::move(instance));
  Accepted accepted = accept_instances(std::move(instances), own.width, own.height, options.min_area,
                                       options.min_score, work);
  smooth_outlines(accepted.labels, own.width, own.height, work);
  Found found;
  for (const double score : accepted.scores) found.confidence.push_back(confidence_of_score(score));
  Particles2D& out = found.particles;
  out.min_area = options.min_area;
  out.labels = std::move(accepted.labels);
  out.coverage.resize(out.labels.size());
  for (std::size_t i = 0; i < out.labels.size(); ++i)
    out.coverage[i] = out.labels[i] > 0 ? std::max(0.5f, own.inside[i]) : std::min(0.499f, own.inside[i]);
  return found;
}

std::vector<double> NetworkView::confidence(const std::vector<std::int32_t>& labels, int count) const {
  std::vector<double> best(count, 0);
  for (const NetworkMaps& maps : scales_) {
    const std::vector<double> scores = score_labels(maps, labels, count);
    for (int k = 0; k < count; ++k) best[k] = std::max(best[k], scores[k]);
  }
  for (double& b : best) b = confidence_of_score(b);
  return best;
}

std::vector<std::uint8_t> NetworkView::not_material() const {
  std::vector<std::uint8_t> out;
  for (const float v : scales_.front().not_material) out.push_back(v > 0.5f);
  return out;
}

}  // namespace terrazzo::segment
