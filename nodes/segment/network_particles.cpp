#include "nodes/segment/network_particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/segment/close_look.h"
#include "nodes/segment/judge.h"

namespace terrazzo::segment {
namespace {

// How much of each pixel the particles cover: labels are whole pixels, so their stairs are smoothed, on the
// right side of one half.
std::vector<float> softened(const std::vector<std::int32_t>& labels, int width, int height) {
  std::vector<float> out(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) out[i] = labels[i] > 0;
  cv::Mat m(height, width, CV_32F, out.data());
  cv::GaussianBlur(m, m, cv::Size(5, 5), 1.0, 1.0, cv::BORDER_REPLICATE);
  for (std::size_t i = 0; i < labels.size(); ++i)
    out[i] = labels[i] > 0 ? std::max(0.5f, out[i]) : std::min(0.499f, out[i]);
  return out;
}

// The best of the candidates that are versions of each other, best first.
template <class Judged>
std::vector<Judged> without_versions(std::vector<Judged> all) {
  constexpr double kSame = 0.5;  // overlap
  std::stable_sort(all.begin(), all.end(),
                   [](const Judged& a, const Judged& b) { return a.score > b.score; });
  std::vector<Judged> kept;
  for (Judged& one : all)
    if (std::none_of(kept.begin(), kept.end(),
                     [&](const Judged& other) { return overlap_of(one.region, other.region) > kSame; }))
      kept.push_back(std::move(one));
  return kept;
}

}  // namespace

double confidence_of_score(double score) { return 1 / (1 + std::exp(3.11 - 8.14 * score)); }

NetworkView::NetworkView(const Image& image, int section, const Network& network, const Work& work) {
  constexpr std::array<double, 4> scales{1, 0.7, 0.5, 0.35};
  picture_ = encoded_section(image, section);
  // Below this the network would only see the mirrored margin.
  constexpr double kSmallest = 96;
  std::vector<double> useful;
  for (const double scale : scales)
    if (scale >= 1 || std::min(image.width, image.height) * scale >= kSmallest) useful.push_back(scale);
  std::vector<NetworkMaps> maps = network(image, section, useful, work);
  std::vector<std::optional<ScaleView>> views(maps.size());
  work.quiet().parallel(maps.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) views[k].emplace(std::move(maps[k]), useful[k], work.quiet());
  });
  for (auto& view : views) scales_.push_back(std::move(*view));
  near_border_ = scales_.front().near_border().clone();
  for (const ScaleView& view : scales_) near_border_ = cv::max(near_border_, view.near_border());
}

std::vector<NetworkView::Place> NetworkView::candidates(double min_area, const Work& work) const {
  std::vector<std::vector<Candidate>> of_scale(scales_.size());
  work.parallel(scales_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) of_scale[k] = scales_[k].candidates(min_area, work.quiet());
  });
  std::vector<Place> places;
  for (std::size_t k = 0; k < scales_.size(); ++k)
    for (const Candidate& c : of_scale[k]) places.push_back({&scales_[k], c});
  return places;
}

std::optional<Evidence> NetworkView::look_at(const Place& place, double min_area, Cutout& region) const {
  region = place.view->cut_out(place.candidate);
  if (region.area() < std::max(1.0, min_area)) return {};
  return evidence_of(region, *place.view, near_border_);
}

void NetworkView::visit_candidates(double min_area, const Work& work, const Visit& visit) const {
  Cutout region;
  for (const Place& place : candidates(min_area, work)) {
    work.check();
    if (const auto evidence = look_at(place, min_area, region)) visit(region, *evidence, *place.view);
  }
}

std::vector<NetworkView::Judged> NetworkView::judged(const NetworkOptions& options, const Work& work) const {
  const std::vector<Place> places = candidates(options.min_area, work.quiet());
  constexpr std::size_t kTogether = 64;
  std::vector<std::vector<Judged>> parts((places.size() + kTogether - 1) / kTogether);
  work.parallel(places.size(), kTogether, [&](std::size_t begin, std::size_t end) {
    std::vector<Judged> part;
    std::vector<Evidence> evidence;
    for (std::size_t i = begin; i < end; ++i) {
      Judged one{{}, places[i].view, 0};
      const auto seen = look_at(places[i], options.min_area, one.region);
      if (!seen) continue;
      evidence.push_back(*seen);
      part.push_back(std::move(one));
    }
    const std::vector<float> scores = built_in_judge()(evidence);
    for (std::size_t k = 0; k < part.size(); ++k) {
      part[k].score = scores[k];
      if (scores[k] >= options.min_score) parts[begin / kTogether].push_back(std::move(part[k]));
    }
  });
  std::vector<Judged> all;
  for (auto& part : parts)
    for (Judged& one : part) all.push_back(std::move(one));
  return all;
}

std::vector<Instance> NetworkView::instances(const NetworkOptions& options, const Work& work) const {
  // A candidate is worth less, the more its outline changes: another one shows that particle better.
  constexpr double kPower = 0.7;
  const std::vector<Judged> all = without_versions(judged(options, work));
  std::vector<Instance> looked(all.size());
  work.parallel(all.size(), kCloseUpsTogether, [&](std::size_t begin, std::size_t end) {
    std::vector<CloseUp> close_ups;
    for (std::size_t i = begin; i < end; ++i) close_ups.push_back(look_closely(all[i].region, *all[i].view));
    const std::vector<cv::Mat> seen = built_in_close_look()(close_ups);
    for (std::size_t i = begin; i < end; ++i) {
      const Cutout& before = all[i].region;
      const Cutout after = redrawn(before, close_ups[i - begin], seen[i - begin], picture_.size());
      if (after.area() < options.min_area) continue;
      looked[i] = {after.pixels(picture_.cols), all[i].score * std::pow(overlap_of(before, after), kPower)};
    }
  });
  std::erase_if(looked,
                [&](const Instance& in) { return in.pixels.empty() || in.score < options.min_score; });
  return looked;
}

NetworkView::Found NetworkView::choose(const std::vector<Instance>& instances, const NetworkOptions& options,
                                       const Work& work) const {
  const NetworkMaps& own = scales_.front().maps();
  Accepted accepted = accept_instances(instances, own.width, own.height, options.min_area, options.min_score,
                                       confidence_of_score, work);
  Found found;
  found.scores = std::move(accepted.scores), found.from = std::move(accepted.from);
  Particles2D& out = found.particles;
  out.min_area = options.min_area;
  out.labels = std::move(accepted.labels);
  out.coverage = softened(out.labels, own.width, own.height);
  return found;
}

double NetworkView::largest_inside(const std::vector<std::int32_t>& pixels) const {
  double largest = 0;
  for (const ScaleView& view : scales_) {
    double sum = 0;
    for (const auto i : pixels) sum += static_cast<double>(view.maps().inside[i]);
    if (!pixels.empty()) largest = std::max(largest, sum / static_cast<double>(pixels.size()));
  }
  return largest;
}

std::vector<double> NetworkView::scores(const std::vector<std::int32_t>& labels, int count,
                                        const Work& work) const {
  const NetworkMaps& own = scales_.front().maps();
  const std::vector<cv::Rect> boxes = boxes_of_labels(labels, own.width, count);
  std::vector<double> best(count, 0);
  work.parallel(count, 16, [&](std::size_t begin, std::size_t end) {
    for (const ScaleView& view : scales_) {
      std::vector<Evidence> evidence;
      std::vector<std::size_t> whose;
      for (std::size_t k = begin; k < end; ++k) {
        if (boxes[k].empty()) continue;
        const Cutout region =
            cut_out_label(labels, own.width, own.height, static_cast<std::int32_t>(k + 1), boxes[k]);
        evidence.push_back(evidence_of(region, view, near_border_));
        whose.push_back(k);
      }
      const std::vector<float> scores = built_in_judge()(evidence);
      for (std::size_t i = 0; i < whose.size(); ++i)
        best[whose[i]] = std::max<double>(best[whose[i]], scores[i]);
    }
  });
  return best;
}

}  // namespace terrazzo::segment
