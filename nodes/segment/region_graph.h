// Regions of a picture, their colours and their borders, and how they merge.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "nodes/segment/lab_image.h"

namespace terrazzo {

struct Region {
  double area = 0;                                // pixels
  double weight = 0;                              // sum of the pixels' weights
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // of weight × colour
  std::map<std::int32_t, float> borders;          // neighbour → length, pixel edges
  Vec3f color() const { return (sum / (weight > 0 ? weight : 1.0)).cast<float>(); }
};

class RegionGraph {
 public:
  // `labels` from 1, none missing; `weights` per pixel let flat pixels tell more of a region's colour than
  // its rim.
  RegionGraph(const LabImage&, const std::vector<std::int32_t>& labels, const std::vector<float>& weights);

  // Merges neighbours in the order of what the merge costs in squared error per length of the border that
  // vanishes (Mumford and Shah's piecewise constant energy; Koepfler, Lopez and Morel 1994) until that
  // exceeds `scale`.
  void merge(double scale, const Work&);

  // Takes a region (label from 1) out: it has no neighbours any more and merges with none.
  void isolate(std::int32_t label);

  // Region of each pixel, numbered from 1 in the order of first appearance.
  std::vector<std::int32_t> labels() const;
  std::vector<Region> regions() const;  // by that number − 1, borders included

 private:
  std::int32_t root(std::int32_t) const;
  std::vector<std::int32_t> pixels_;
  std::vector<Region> regions_;
  mutable std::vector<std::int32_t> parent_;
};

}  // namespace terrazzo
