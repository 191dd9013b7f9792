#include "nodes/detail/residual/scratches.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

constexpr std::uint64_t kScratchStream = 0x73637261;
constexpr int kScratchReach = Detail::Scratch::kReach;
constexpr float kScratchFade = 6;  // pixels of the photograph at both ends

// Mean of the profile over a pixel; lengths are in pixels of the photograph.
float value_across(const Detail::Scratch& s, float across, float edge) {
  constexpr int kSamples = 5;
  float sum = 0;
  for (int k = 0; k < kSamples; ++k) {
    const float at = across + edge * ((k + 0.5f) / kSamples - 0.5f) + kScratchReach;
    if (at <= 0 || at >= 2 * kScratchReach) continue;
    const int below = round_down(at);
    const float t = at - below;
    sum += (1 - t) * s.profile[below] + t * s.profile[below + 1];
  }
  return sum / kSamples;
}

struct Scratched {
  Vec3f* pixels;
  std::span<const float> cover;
  int width, height;
  bool wrap;
};

// `x`, `y`: the middle, pixels of the picture; `edge`: of a pixel, in pixels of the photograph.
void draw_scratch(const Scratched& canvas, const Detail::Scratch& s, double x, double y, float edge) {
  const float c = std::cos(s.angle), d = -std::sin(s.angle);  // rows run downwards
  const double half = s.length / 2 / edge, beside = kScratchReach / edge + 1;
  const double wide = std::abs(c) * half + beside, high = std::abs(d) * half + beside;
  for (int v = round_down(y - high); v <= round_up(y + high); ++v)
    for (int u = round_down(x - wide); u <= round_up(x + wide); ++u) {
      if (!canvas.wrap && (u < 0 || v < 0 || u >= canvas.width || v >= canvas.height)) continue;
      const float dx = static_cast<float>(u + 0.5 - x) * edge, dy = static_cast<float>(v + 0.5 - y) * edge;
      const float left = s.length / 2 - std::abs(dx * c + dy * d), across = dx * d - dy * c;
      if (left <= 0 || std::abs(across) > kScratchReach + edge) continue;
      const std::size_t at = pixel_at(canvas.wrap ? wrap_index(u, canvas.width) : u,
                                      canvas.wrap ? wrap_index(v, canvas.height) : v, canvas.width);
      const float share = 1 - std::clamp(canvas.cover[at], 0.0f, 1.0f);
      const float value =
          share * std::min(1.0f, left / kScratchFade) * value_across(s, across, std::max(edge, 0.2f));
      Vec3f encoded = linear_to_srgb(canvas.pixels[at]);
      encoded.array() += value;
      canvas.pixels[at] = srgb_to_linear(encoded.cwiseMax(0.0f));
    }
}

}  // namespace

void add_scratches(Vec3f* pixels, std::span<const float> cover, int width, int height, double pixel,
                   bool wrap, const Camera& camera, std::uint64_t picture, const Work& work) {
  if (!camera.scratched || camera.scratched->scratches.empty()) return;
  const double edge = pixel / camera.noise_pixel;
  Random random(mix64(camera.seed ^ kScratchStream), picture);
  for (const Detail::Scratch& s : camera.scratched->scratches) {
    const double margin = wrap ? 0 : s.length / edge;
    const double wide = width + 2 * margin, high = height + 2 * margin;
    const double expected = wide * high * edge * edge / s.area;
    const int count = round_down(std::min(expected, 1e5) + random.uniform());
    for (int i = 0; i < count; ++i) {
      work.check();
      const double x = random.uniform() * wide - margin, y = random.uniform() * high - margin;
      draw_scratch({pixels, cover, width, height, wrap}, s, x, y, static_cast<float>(edge));
    }
  }
}

}  // namespace terrazzo::residual
