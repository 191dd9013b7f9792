// Particles by the trained network.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/segment/color/particles.h"
#include "nodes/photograph/segment/network/close_up.h"
#include "nodes/photograph/segment/network/evidence.h"
#include "nodes/photograph/segment/network/instances.h"
#include "nodes/photograph/segment/network/network.h"

namespace terrazzo::segment {

struct NetworkOptions {
  double min_area = 25;     // pixels; smaller particles are dropped
  double min_score = 0.35;  // particles below it are dropped
};

// What the network says of one section at several scales, since it knows particles of a few to a few hundred
// pixels. Sizes, labels and pixels of all functions are those of the section, whatever its reduction.
class NetworkView {
 public:
  // `reduction`, up to 1: the scale of the picture that stands for the section (sharpness.h).
  NetworkView(const Image&, int section, double reduction, const Network&, const Work&);

  // The candidates of all scales with the outlines of the close look and their scores, about the overlap with
  // a particle to expect: what the judge expects of the candidate, less if its outline changed. Several may
  // cover the same place. Candidates that the judge is sure of keep their outlines; those that lie mostly on
  // better ones are left out.
  std::vector<Instance> instances(const NetworkOptions&, const Work&) const;

  // The evidence of each candidate of at least min_area pixels, to learn from; in a fixed order. Without a
  // reduction only.
  using Visit = std::function<void(const Cutout&, const Evidence&, const ScaleView&)>;
  void visit_candidates(double min_area, const Work&, const Visit&) const;

  CloseUp look_closely(const Cutout& region, const ScaleView& view) const {
    return close_up(region, picture_, view, scales_.front());
  }

  // The best ones, by score, among instances of any origin.
  struct Found {
    Particles2D particles;
    std::vector<double> scores;     // of label k at k − 1
    std::vector<std::size_t> from;  // which instance label k was, at k − 1
  };
  Found choose(const std::vector<Instance>&, const NetworkOptions&, const Work&) const;

  // The score of each of the labels from 1 to `count` at the scale that judges it best.
  std::vector<double> scores(const std::vector<std::int32_t>& labels, int count, const Work&) const;
  // The mean of `inside` over these pixels, at the scale where it is largest; 0 without pixels.
  double largest_inside(const std::vector<std::int32_t>& pixels) const;
  // 1 for pixels without a label where `inside` exceeds one half at some scale: particles that were not
  // found.
  UndecidedPixels undecided(const std::vector<std::int32_t>& labels) const;
  // From 0 to 1, how likely a pixel shows a ruler, frame or text.
  std::vector<float> not_material() const;

 private:
  struct Place {
    const ScaleView* view;
    Candidate candidate;
  };
  std::vector<Place> candidates(double min_area, const Work&) const;
  // Candidates of at least min_score, in a fixed order.
  struct Judged {
    Cutout region;
    const ScaleView* view;
    double score;
  };
  std::vector<Judged> judged(const NetworkOptions&, const Work&) const;
  std::optional<Evidence> look_at(const Place&, double min_area, Cutout&) const;  // none: too small
  std::size_t reduced_index(int x, int y) const;  // of a pixel of the section, in the maps
  std::vector<std::int32_t> reduced(const std::vector<std::int32_t>& labels) const;
  struct Looked {
    Cutout region;    // of the reduced section; empty: nothing is left
    Cutout enlarged;  // of the section, if that is reduced
    double score = 0;
  };
  std::vector<Looked> close_looks(std::span<const Judged* const>, double min_area) const;

  int width_, height_;  // of the section
  double reduction_;
  cv::Mat picture_;                // the reduced section, as encoded_section() gives it
  std::vector<ScaleView> scales_;  // the first one is the picture's own
  cv::Mat near_border_;            // the largest of all scales
};

// The share of particles with such a score that overlap a true one by at least half, among synthetic pictures
// that the network was not trained on.
double confidence_of_score(double score);

}  // namespace terrazzo::segment
