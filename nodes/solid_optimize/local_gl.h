// The same passes by compute shaders.
#pragma once

#include <memory>
#include <string>

#include "nodes/common/egl_context.h"
#include "nodes/solid_optimize/local_passes.h"

namespace terrazzo::solid_optimize {

// Lives on the thread that made it.
class LocalGl {
 public:
  // Throws Error "no-gl" where there is no such device or it refuses the shaders.
  explicit LocalGl(GlDevice);
  ~LocalGl();

  // From the carried matches of a region to its matches and weights, and to its field if `to_blend`. Sums are
  // taken in the processor's order, so that only its divisions, roots and fused products may round otherwise;
  // where two patches are then as near as that, another may be taken. Throws Error "too-large-for-gl" where
  // the region does not fit into the device's buffers.
  void run(const LocalPasses&, bool to_blend, LocalProbe*, LocalRegion&, const Work&);
  const std::string& renderer() const;

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
};

}  // namespace terrazzo::solid_optimize
