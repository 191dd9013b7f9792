// What the network says of each section of a stack.
#pragma once

#include <memory>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/segment/network/network_particles.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// The maps of a stack can exceed its memory many times over. So those of large stacks are made again whenever
// they are needed.
class NetworkSections {
 public:
  // `image` is what the network sees, reduced by `scale`. Candidates that lie mostly on `ignored` pixels are
  // left out; these may become more while sections are looked at. All references must stay valid.
  NetworkSections(const Image& image, double scale, const Network&, const NetworkOptions& candidates,
                  const IgnoredPixels& ignored);

  std::shared_ptr<const NetworkView> view(int section, const Work&);
  std::vector<Instance> candidates(int section, const Work&);

 private:
  const Image& image_;
  double scale_;
  const Network& network_;
  NetworkOptions options_;
  const IgnoredPixels& ignored_;
  bool keep_;
  std::vector<std::shared_ptr<const NetworkView>> views_;
  std::vector<std::vector<Instance>> candidates_;
};

}  // namespace terrazzo::segment
