// The blockwise passes as compute shaders.
#pragma once

#include <memory>
#include <string>

#include "nodes/common/gl/egl_context.h"
#include "nodes/solids/synthesis/blockwise/finish.h"

namespace terrazzo::solids {

// Must be used on the thread that made it.
class BlockGl {
 public:
  // Throws Error "no-gl" if there is no such device or it rejects the shaders.
  explicit BlockGl(GlDevice);
  ~BlockGl();

  // Turns the carried matches of a region into its matches and weights, and into its field if `to_blend`.
  // If `finish` is not null, then finishes the field and leaves the weights as they were.
  // Sums run in the processor's order, so only divisions, roots and fused products may round differently;
  // where two patches are equally near within that rounding, the match may differ. Throws Error
  // "too-large-for-gl" if the region does not fit into the device's buffers.
  void run(const BlockPasses&, bool to_blend, BlockProbe*, const BlockFinish* finish, BlockRegion&,
           const Work&);
  const std::string& renderer() const;

 private:
  struct Gl;
  struct LineTables;
  struct ExemplarBuffers;
  class Run;
  std::unique_ptr<Gl> gl_;
};

}  // namespace terrazzo::solids
