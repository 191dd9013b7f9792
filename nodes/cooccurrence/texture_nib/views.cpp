#include "nodes/cooccurrence/texture_nib/views.h"

namespace terrazzo::texture_nib {

Image base_relative_view(const Nib& nib) {
  const Image& p = nib.picture();
  Image out(p.width, p.height, 1, p.pixel_size);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const auto level = nib.base_relative()[i];
    out.pixels[i] = level == kNoLevel ? Vec3f(1, 0, 1) : nib.texture().levels.color[level];
  }
  return out;
}

Image occupancy_view(const Nib& nib) {
  const Image& p = nib.picture();
  Image out(p.width, p.height, 1, p.pixel_size);
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    out.pixels[i] = Vec3f::Constant(nib.occupancy()[i] ? 1.0f : 0.0f);
  return out;
}

}  // namespace terrazzo::texture_nib
