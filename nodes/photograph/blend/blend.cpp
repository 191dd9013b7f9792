#include "nodes/photograph/blend/blend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "graph/diagnostic.h"

namespace terrazzo::blend {
namespace {

template <typename Picture>
void require_size(const Image& below, const Picture& other, const std::string& port) {
  const bool sections = other.sections == below.sections || other.sections == 1;
  if (other.width == below.width && other.height == below.height && sections) return;
  throw Error(
      "size-mismatch",
      fmt::format("{} has {} × {} pixels and {} sections; image has {} × {} and {}", port, other.width,
                  other.height, other.sections, below.width, below.height, below.sections),
      "connect pictures of equal size");
}

// Compositing and Blending Level 1, of the W3C, section 9.1.
float blended(float below, float over, Mode mode) {
  switch (mode) {
    case Mode::Mix:
      return over;
    case Mode::Multiply:
      return below * over;
    case Mode::Screen:
      return below + over - below * over;
    case Mode::Overlay:
      return below <= 0.5f ? 2 * below * over : 1 - 2 * (1 - below) * (1 - over);
    case Mode::Add:
      return below + over;
    case Mode::Subtract:
      return below - over;
    case Mode::Difference:
      return std::abs(below - over);
  }
  return over;
}

float share_of(const Mask& mask, std::size_t i) {
  if (mask.image) return std::clamp(mask.image->pixels[i % mask.image->pixels.size()].mean(), 0.0f, 1.0f);
  if (mask.labels) return mask.labels->ids[i % mask.labels->ids.size()] > 0 ? 1.0f : 0.0f;
  return 1;
}

}  // namespace

Image blend_images(const Image& below, const Image& over, const Mask& mask, Mode mode, double amount,
                   const Work& work) {
  if (below.pixels.empty()) throw Error("empty-image", "the image has no pixels", "connect an image");
  require_size(below, over, "over");
  if (mask.image) require_size(below, *mask.image, "mask");
  if (mask.labels) require_size(below, *mask.labels, "mask");
  Image out = below;
  work.parallel(out.pixels.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f upper = over.pixels[i % over.pixels.size()];
      const float share = static_cast<float>(amount) * share_of(mask, i);
      if (share <= 0) continue;
      for (int channel = 0; channel < 3; ++channel) {
        float& v = out.pixels[i][channel];
        v = std::max(v + share * (blended(v, upper[channel], mode) - v), 0.0f);
      }
    }
  });
  return out;
}

}  // namespace terrazzo::blend
