// Regions of the network's maps that may be particles.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "nodes/photograph/segment/network/network.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// A region of a section with its surroundings.
struct Cutout {
  cv::Rect box;  // includes a margin of 6 pixels, clipped to the section
  cv::Mat mask;  // bytes of the box: 1 within the region, 0 elsewhere

  std::vector<std::int32_t> pixels(int width) const;  // indices in a section of this width, ascending
  int area() const;                                   // pixels
};

// Intersection over union of two regions of one section; 0 if both are empty.
double overlap_of(const Cutout&, const Cutout&);

// A basin of the maps, or a component of the pixels where inside × (1 − border) exceeds `level`.
struct Candidate {
  cv::Rect box;            // without a margin
  std::int32_t basin = 0;  // 0: a component
  cv::Point seed;          // one of the component's pixels
  float level = 0;
};

// The maps of one section at one scale, with what is needed to find and judge regions.
class ScaleView {
 public:
  ScaleView(NetworkMaps maps, double scale, const Work&);

  // All basins, and the 4-connected components of at least half of `min_area` pixels at 19 levels from 0.04
  // to 0.9. Left out are components with more than 0.8 of the pixels of the one around them, at the level
  // below, and those above 10,000 pixels that cover more than 0.7 of the section or less than 0.2 of their
  // box.
  std::vector<Candidate> candidates(double min_area, const Work&) const;
  // The candidate as a particle. A component is enlarged by the inner border that the level cuts off,
  // smoothed by a median of 3 × 3 pixels, without holes.
  Cutout cut_out(const Candidate&) const;

  const NetworkMaps& maps() const { return maps_; }
  double scale() const { return scale_; }
  cv::Mat map(const std::vector<float>& values) const;         // a view of one of the maps
  const cv::Mat& near_border() const { return near_border_; }  // the largest border of 3 × 3 pixels

 private:
  NetworkMaps maps_;
  double scale_;
  cv::Mat near_border_, within_;  // within: inside × (1 − border)
  std::vector<std::int32_t> basins_;
};

// Adds to a mask of 0 and 1 what the outside cannot reach.
void fill_holes_of(cv::Mat& mask);

// The box of each of the labels from 1 to `count`; empty if it has no pixels.
std::vector<cv::Rect> boxes_of_labels(const std::vector<std::int32_t>& labels, int width, int count);

// A region with a margin, from some of the labels of a section.
Cutout cut_out_label(const std::vector<std::int32_t>& labels, int width, int height, std::int32_t label,
                     const cv::Rect& box);

}  // namespace terrazzo::segment
