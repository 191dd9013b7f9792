// The candidates from network to outlines: judged, compared, looked at closely.
#include <algorithm>
#include <cmath>

#include "nodes/photograph/segment/network/close_look.h"
#include "nodes/photograph/segment/network/judge.h"
#include "nodes/photograph/segment/network/network_particles.h"

namespace terrazzo::segment {
namespace {

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

// The best score of the instances at each pixel of the reduced section.
class Claims {
 public:
  explicit Claims(const cv::Mat& picture) : width_(picture.cols), best_(picture.total(), 0) {}

  void add(const Cutout& region, double score) {
    for (const auto i : region.pixels(width_)) best_[i] = std::max(best_[i], score);
  }
  // Whether most of the region has a better one, so that it would not be accepted whatever its outline.
  bool exceed(const Cutout& region, double score) const {
    constexpr double kCovered = 0.4;  // as for accepted instances
    const auto pixels = region.pixels(width_);
    const auto lost = std::count_if(pixels.begin(), pixels.end(), [&](auto i) { return best_[i] >= score; });
    return lost >= kCovered * pixels.size();
  }

 private:
  int width_;
  std::vector<double> best_;
};

}  // namespace

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

std::vector<NetworkView::Looked> NetworkView::close_looks(std::span<const Judged* const> some,
                                                          double min_area) const {
  // A candidate is worth less, the more its outline changes: another one shows that particle better.
  constexpr double kPower = 0.7;
  std::vector<CloseUp> close_ups;
  for (const Judged* one : some) close_ups.push_back(look_closely(one->region, *one->view));
  const std::vector<cv::Mat> seen = built_in_close_look()(close_ups);
  std::vector<Looked> out(some.size());
  for (std::size_t k = 0; k < some.size(); ++k) {
    const Cutout& before = some[k]->region;
    Cutout after = redrawn(before, close_ups[k], seen[k], picture_.size());
    if (after.area() < min_area) continue;
    out[k].score = some[k]->score * std::pow(overlap_of(before, after), kPower);
    if (reduction_ < 1)
      out[k].enlarged = enlarged(after, close_ups[k], seen[k], picture_.size(), {width_, height_});
    out[k].region = std::move(after);
  }
  return out;
}

std::vector<Instance> NetworkView::instances(const NetworkOptions& given, const Work& work) const {
  NetworkOptions options = given;
  options.min_area *= reduction_ * reduction_;
  constexpr double kSure = 0.8;        // an outline that good cannot be improved
  constexpr std::size_t kRound = 256;  // candidates that are looked at before the next ones are chosen
  const std::vector<Judged> all = without_versions(judged(options, work));  // best first
  std::vector<Instance> instances;
  const auto keep = [&](const Cutout& region, int width, double score) {
    if (score >= options.min_score) instances.push_back({region.pixels(width), score});
  };
  Claims claims(picture_);
  std::vector<const Judged*> chosen;
  for (std::size_t next = 0; next < all.size();) {
    work.check();
    chosen.clear();
    for (; next < all.size() && chosen.size() < kRound; ++next) {
      const Judged& one = all[next];
      if (claims.exceed(one.region, one.score)) continue;
      if (one.score < kSure || reduction_ < 1) {
        chosen.push_back(&one);
      } else {
        keep(one.region, picture_.cols, one.score);
        claims.add(one.region, one.score);
      }
    }
    std::vector<Looked> looked(chosen.size());
    work.quiet().parallel(chosen.size(), kCloseUpsTogether, [&](std::size_t begin, std::size_t end) {
      auto some = close_looks(std::span(chosen).subspan(begin, end - begin), options.min_area);
      std::move(some.begin(), some.end(), looked.begin() + begin);
    });
    for (const Looked& one : looked) {
      if (one.region.mask.empty()) continue;
      reduction_ < 1 ? keep(one.enlarged, width_, one.score) : keep(one.region, width_, one.score);
      claims.add(one.region, one.score);
    }
  }
  return instances;
}

}  // namespace terrazzo::segment
