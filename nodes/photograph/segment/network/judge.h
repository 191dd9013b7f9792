// How likely a region is a particle.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "nodes/photograph/segment/network/evidence.h"

namespace terrazzo::segment {

class Judge {
 public:
  // `bytes`: an ONNX model with input (n, 14), the evidence of n regions, and output (n, 1) from 0 to 1.
  // Throws Error "bad-model".
  explicit Judge(std::string bytes);
  ~Judge();
  Judge(const Judge&) = delete;
  Judge& operator=(const Judge&) = delete;

  // The expected intersection over union of each region with the particle that it overlaps most. May be
  // called from several threads.
  std::vector<float> operator()(std::span<const Evidence>) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

// The one that comes with the program, trained on regions of synthetic pictures;
// nodes/photograph/segment/training describes how.
const Judge& built_in_judge();

}  // namespace terrazzo::segment
