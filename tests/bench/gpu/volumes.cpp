#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/volumes/phantom/phantom.h"
#include "nodes/volumes/render_volume/gl_march.h"
#include "nodes/volumes/render_volume/scene.h"
#include "tests/bench/gpu/measure.h"

namespace terrazzo::gpu {
namespace {
using namespace render_volume;

constexpr int kFrames = 36;

SolidTexture texture(std::uint64_t seed, const Vec3f& color) {
  constexpr std::size_t kSide = 128;
  std::vector<Vec3f> c(kSide * kSide * kSide);
  Work().parallel(c.size(), kSide * kSide, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const Vec3 at(double(i % kSide), double(i / kSide % kSide), double(i / kSide / kSide));
      c[i] = color * (1 + 0.4f * static_cast<float>(noise(seed, at * 0.125)));
    }
  });
  return SolidTexture(Vec3i::Constant(kSide), 0.1f, c);
}

// The limb of table 1 of Laursen et al. 2011.
Scene limb_scene(int edge) {
  phantom::LimbOptions limb;
  limb.resolution = Vec3i::Constant(edge);
  Look look;
  look.up = 1;
  return Scene(scan_field(limb.resolution, limb.spacing(), phantom::limb(limb)),
               parse_tissues({"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9 texture",
                              "muscle -30 150 #8f3a36 texture", "bone 150 4000 #efe6cf texture"}),
               {texture(1, Vec3f(0.8f, 0.7f, 0.4f)), texture(2, Vec3f(0.3f, 0.05f, 0.04f)),
                texture(3, Vec3f(0.85f, 0.8f, 0.6f))},
               look);
}

double azimuth(int frame) { return -139 + 360.0 * frame / kFrames; }

struct Difference {
  double mean = 0, largest = 0, share = 0;  // of color values; pixels with one of more than 1/255
};

Difference difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  Difference d;
  const auto n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec3f apart = (a[i] - b[i]).cwiseAbs();
    d.mean += apart.mean() / n;
    d.largest = std::max<double>(d.largest, apart.maxCoeff());
    d.share += (apart.maxCoeff() > 1.0f / 255) / n;
  }
  return d;
}

struct Turn {
  double drawn, read;  // seconds per frame: left on the device, and as a picture in memory
  double processor;
  Difference difference;
};

Turn turn(const Options& o, const Scene& scene, const Bricks& bricks) {
  const int step = o.quick ? 36 : 1, frames = kFrames / step;
  GlMarcher marcher(scene, bricks, o.device);
  Turn t;
  FrameCounts counts;
  t.drawn = median(repeated(o,
                            [&] {
                              for (int i = 0; i < kFrames; i += step)
                                marcher.draw(frame_of(scene, azimuth(i)));
                            })) /
            frames;
  t.read = median(repeated(o,
                           [&] {
                             for (int i = 0; i < kFrames; i += step)
                               marcher.march(frame_of(scene, azimuth(i)), counts);
                           })) /
           frames;
  std::vector<Vec3f> reference;
  double seconds = 0;
  constexpr int kCompared = 3;
  for (int i = 0; i < kCompared; ++i) {
    const Frame f = frame_of(scene, azimuth(i * kFrames / kCompared));
    seconds += seconds_of([&] { reference = march(scene, f, bricks, counts); });
    const Difference d = difference(marcher.march(f, counts), reference);
    t.difference.mean += d.mean / kCompared;
    t.difference.share += d.share / kCompared;
    t.difference.largest = std::max(t.difference.largest, d.largest);
  }
  t.processor = seconds / kCompared;
  return t;
}

void measure_picture(const Options& o, Scene scene, int width, int height, const Tell& tell) {
  scene.look.width = width;
  scene.look.height = height;
  const Bricks bricks(scene.scan, scene.intervals);
  Turn turns[2];
  for (const bool textured : {false, true}) {
    scene.look.textured = textured;
    const Turn t = turns[textured] = turn(o, scene, bricks);
    tell(fmt::format(
             "volume {}³ at {} × {}, {}: {:.0f} frames per second, {:.0f} when read back, processor {:.1f}; "
             "mean difference {:.1g}, largest {:.2g}, {:.3g} % of pixels above 1/255",
             scene.scan.size.x(), width, height, textured ? "three textures" : "plain", 1 / t.drawn,
             1 / t.read, 1 / t.processor, t.difference.mean, t.difference.largest, 100 * t.difference.share),
         {{"kind", "volume"},
          {"edge", scene.scan.size.x()},
          {"width", width},
          {"height", height},
          {"textured", textured},
          {"seconds", t.drawn},
          {"seconds_read_back", t.read},
          {"processor_seconds", t.processor},
          {"mean_difference", t.difference.mean},
          {"largest_difference", t.difference.largest},
          {"differing_share", t.difference.share}});
  }
  tell(fmt::format("  textured takes {:.3f} times as long", turns[1].drawn / turns[0].drawn),
       {{"kind", "volume_ratio"}, {"ratio", turns[1].drawn / turns[0].drawn}});
}

}  // namespace

void measure_volumes(const Options& o, const Tell& tell) {
  for (const int edge : o.quick ? std::vector<int>{48} : std::vector<int>{256, 512}) {
    if (edge > o.most) continue;
    const Scene scene = limb_scene(edge);
    if (o.quick) {
      measure_picture(o, scene, 64, 48, tell);
      continue;
    }
    measure_picture(o, scene, 512, 512, tell);
    measure_picture(o, scene, 1920, 1080, tell);
  }
}

}  // namespace terrazzo::gpu
