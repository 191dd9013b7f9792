// The blockwise passes as compute shaders.
#pragma once

#include <memory>
#include <string>

#include "nodes/common/egl_context.h"
#include "nodes/solid_optimize/local_passes.h"

namespace terrazzo::solid_optimize {

// Must be used on the thread that made it.
class LocalGl {
 public:
  // Throws Error "no-gl" if there is no such device or it rejects the shaders.
  explicit LocalGl(GlDevice);
  ~LocalGl();

  // Turns the carried matches of a region into its matches and weights, and into its field if `to_blend`.
  // Sums run in the processor's order, so only divisions, roots and fused products may round differently;
  // where two patches are equally near within that rounding, the match may differ. Throws Error
  // "too-large-for-gl" if the region does not fit into the device's buffers.
  void run(const LocalPasses&, bool to_blend, LocalProbe*, LocalRegion&, const Work&);
  const std::string& renderer() const;

 private:
  struct Gl;
  std::unique_ptr<Gl> gl_;
};

}  // namespace terrazzo::solid_optimize
