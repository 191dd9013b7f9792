// Regions of an image with their colors and borders, and region merging.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "nodes/photograph/segment/color/lab_image.h"

namespace terrazzo::segment {

struct Region {
  double area = 0;                                // pixels
  double weight = 0;                              // sum of the pixel weights
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // of weight × color
  std::map<std::int32_t, float> borders;          // neighbor → length in pixel edges
  Vec3f color() const { return (sum / (weight > 0 ? weight : 1.0)).cast<float>(); }
};

class RegionGraph {
 public:
  // `labels` are numbered from 1 without gaps. `weights` per pixel let flat pixels count more for a region's
  // color than pixels at its rim.
  RegionGraph(const LabImage&, const std::vector<std::int32_t>& labels, const std::vector<float>& weights);

  // Merges neighbors in the order of the increase in squared error per length of the removed border, until
  // that cost exceeds `scale` (piecewise constant Mumford–Shah energy; Koepfler, Lopez and Morel 1994).
  void merge(double scale, const Work&);

  // Isolates a region (label from 1): it has no neighbors anymore and never merges.
  void isolate(std::int32_t label);

  // Region of each pixel, numbered from 1 in order of first appearance.
  std::vector<std::int32_t> labels() const;
  std::vector<Region> regions() const;  // at that number − 1, including borders

 private:
  std::int32_t root(std::int32_t) const;
  std::vector<std::int32_t> pixels_;
  std::vector<Region> regions_;
  mutable std::vector<std::int32_t> parent_;
};

}  // namespace terrazzo::segment
