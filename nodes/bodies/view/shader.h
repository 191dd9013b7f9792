// How much light the points of a bed receive.
#pragma once

#include <cstdint>

#include "nodes/bodies/view/bed.h"
#include "nodes/bodies/view/light.h"

namespace terrazzo::view {

// Light is relative to that of level ground in the open.
class Shader {
 public:
  // `reach`: mm up to which stones hide the sky; `lift`: mm by which rays start above their surface. The bed
  // must outlive the shader.
  Shader(const Bed&, const Light&, double reach, double lift);

  // Of the sun: Lambert's law and the shadows of stones, soft because the sun is eight places on a disc,
  // turned by the random number.
  float sun(const BedPoint&, std::uint64_t random) const;
  // Of an overcast sky, what stones and the ground leave open, weighted by the cosine to the normal: 16
  // stratified directions, shifted by the random number, or up to 192 where few are open. Never 0.
  float sky(const BedPoint&, std::uint64_t random) const;

 private:
  Vec3f toward_sun(int place, float shift) const;
  float open_rays(const BedPoint&, float shift, float turn) const;  // of 16
  Vec3f start(const BedPoint& point) const { return point.at + lift_ * point.face; }

  const Bed& bed_;
  float reach_, lift_;
  float level_ = 0;  // what the places on the sun give level ground if they are not turned
  Vec3f middle_;     // of the sun
};

}  // namespace terrazzo::view
