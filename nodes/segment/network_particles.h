// Particles by the trained network.
#pragma once

#include "nodes/data/image.h"
#include "nodes/segment/network.h"
#include "nodes/segment/particles.h"

namespace terrazzo::segment {

struct NetworkOptions {
  double min_area = 25;    // pixels; smaller particles are dropped
  double min_score = 0.1;  // particles below it are dropped
};

// What the network says of one section at several scales, since it knows particles of a few to a few hundred
// pixels.
class NetworkView {
 public:
  NetworkView(const Image&, int section, const Network&, const Work&);

  // The best instances of all scales.
  struct Found {
    Particles2D particles;
    std::vector<double> confidence;  // of label k at k − 1
  };
  Found find_particles(const NetworkOptions&, const Work&) const;

  // The confidence that each of the labels from 1 to `count` is one particle, outlined correctly.
  std::vector<double> confidence(const std::vector<std::int32_t>& labels, int count) const;
  // 1 where the network sees a ruler, frame or text.
  std::vector<std::uint8_t> not_material() const;

 private:
  std::vector<NetworkMaps> scales_;  // the first one is the picture's own
};

// The share of particles with such a score that overlap a true one by at least half, among synthetic pictures
// that the network was not trained on.
double confidence_of_score(double score);

}  // namespace terrazzo::segment
