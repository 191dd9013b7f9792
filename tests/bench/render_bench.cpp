// Renders one turn around a scan of 256³ voxels at 512² pixels: table 1 of Laursen et al. 2011. `min`, `max`
// and `mean` are frames per second. The baseline marches like the paper, with steps of a thousandth of the
// volume's edge and without skipping empty space, and is timed only on every twelfth frame. Also renders 512²
// images of a carved vase at 64 paths per pixel.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/forms.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/render_solid/render.h"
#include "nodes/common/texture/noise.h"
#include "nodes/volumes/phantom/phantom.h"
#include "nodes/volumes/render_volume/gl_march.h"
#include "nodes/volumes/render_volume/scene.h"

namespace terrazzo {
namespace {
using namespace carving;
using namespace render_solid;
using namespace render_volume;

constexpr int kFrames = 36;

SolidTexture texture(std::uint64_t seed, const Vec3f& color) {
  std::vector<Vec3f> c(128 * 128 * 128);
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto w = static_cast<float>(
        noise(seed, Vec3(double(i % 128), double(i / 128 % 128), double(i / 16384)) * 0.125));
    c[i] = color * (1 + 0.4f * w);
  }
  return SolidTexture(Vec3i(128, 128, 128), 0.1f, c);
}

const Scene& scene() {
  static const Scene s = [] {
    phantom::LimbOptions limb;
    limb.resolution = Vec3i(256, 256, 256);
    Look look;
    look.up = 1;
    return Scene(scan_field(limb.resolution, limb.spacing(), phantom::limb(limb)),
                 parse_tissues({"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9 texture",
                                "muscle -30 150 #8f3a36 texture", "bone 150 4000 #efe6cf texture"}),
                 {texture(1, Vec3f(0.8f, 0.7f, 0.4f)), texture(2, Vec3f(0.3f, 0.05f, 0.04f)),
                  texture(3, Vec3f(0.85f, 0.8f, 0.6f))},
                 look);
  }();
  return s;
}

Scene with(bool textured, bool opened) {
  Scene s = scene();
  s.look.textured = textured;
  if (opened) s.look.clip[1].y() = 0.5f;  // half of the limb, where skin is visible only at the rim
  return s;
}

template <class Draw>
void turn(benchmark::State& state, const Scene& s, int step, Draw&& draw) {
  double least = 1e9, most = 0, seconds = 0;
  int frames = 0;
  for (auto _ : state)
    for (int i = 0; i < kFrames; i += step) {
      const Frame f = frame_of(s, -139 + 360.0 * i / kFrames);
      const auto start = std::chrono::steady_clock::now();
      draw(f);
      const double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      least = std::min(least, 1 / t), most = std::max(most, 1 / t), seconds += t, ++frames;
    }
  state.counters["min"] = least, state.counters["max"] = most, state.counters["mean"] = frames / seconds;
  state.counters["ms_a_frame"] = 1000 * seconds / frames;
}

// Renders each frame plain, then textured, so that the machine is in the same state for both.
void march_turn(benchmark::State& state, bool opened) {
  const Scene plain = with(false, opened), textured = with(true, opened);
  const Bricks bricks(plain.scan, plain.intervals);
  struct Rate {
    double least = 1e9, most = 0, seconds = 0;
    void add(double t) { least = std::min(least, 1 / t), most = std::max(most, 1 / t), seconds += t; }
  } rates[2];
  int frames = 0;
  for (auto _ : state)
    for (int i = 0; i < kFrames; ++i, ++frames)
      for (int k = 0; k < 2; ++k) {
        const Scene& s = k ? textured : plain;
        const Frame f = frame_of(s, -139 + 360.0 * i / kFrames);
        FrameCounts c;
        const auto start = std::chrono::steady_clock::now();
        benchmark::DoNotOptimize(march(s, f, bricks, c));
        rates[k].add(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
      }
  for (int k = 0; k < 2; ++k) {
    const std::string name = k ? "textured_" : "plain_";
    state.counters[name + "min"] = rates[k].least, state.counters[name + "max"] = rates[k].most;
    state.counters[name + "mean"] = frames / rates[k].seconds;
    state.counters[name + "ms"] = 1000 * rates[k].seconds / frames;
  }
  state.counters["ratio"] = rates[1].seconds / rates[0].seconds;
}
void render_turn(benchmark::State& state) { march_turn(state, false); }
BENCHMARK(render_turn)->Unit(benchmark::kMillisecond)->UseRealTime();
void render_turn_opened(benchmark::State& state) { march_turn(state, true); }
BENCHMARK(render_turn_opened)->Unit(benchmark::kMillisecond)->UseRealTime();

void render_baseline_every_step(benchmark::State& state) {
  Scene s = with(false, false);
  s.look.skip_empty = false;
  s.look.step = 0.001 * s.scan.extent().maxCoeff() / s.scan.spacing.minCoeff();
  // To disable skipping, every brick must store its voxels: add a transparent class that includes air.
  s.tissues = parse_tissues({"air -5000 -600 opacity=0", "skin -600 -190 #d9a58c noise opacity=0.25",
                             "fat -190 -30 #ead9a9", "muscle -30 150 #8f3a36", "bone 150 4000 #efe6cf"});
  s = Scene(s.scan, s.tissues, {}, s.look);
  const Bricks bricks(s.scan, s.intervals);
  turn(state, s, 12, [&](const Frame& f) {
    FrameCounts c;
    benchmark::DoNotOptimize(march(s, f, bricks, c));
  });
}
BENCHMARK(render_baseline_every_step)->Unit(benchmark::kMillisecond)->UseRealTime();

// terrazzo_gpu measures GPUs (tests/bench/gpu).
void render_llvmpipe(benchmark::State& state) {
  const Scene s = with(false, false);
  const Bricks bricks(s.scan, s.intervals);
  try {
    GlMarcher gl(s, bricks, GlDevice::Cpu);
    state.SetLabel(gl.renderer());
    turn(state, s, 12, [&](const Frame& f) {
      FrameCounts c;
      benchmark::DoNotOptimize(gl.march(f, c));
    });
  } catch (const Error& e) {
    state.SkipWithError(e.what());
  }
}
BENCHMARK(render_llvmpipe)->Unit(benchmark::kMillisecond)->UseRealTime();

void render_vase_64(benchmark::State& state) {
  constexpr int n = 128;
  std::vector<Vec3f> colors(n * n * n);
  for (std::size_t i = 0; i < colors.size(); ++i)
    colors[i] = Vec3f::Constant(
        float(0.5 + 0.4 * noise(3, Vec3(double(i % n), double(i / n % n), double(i / n / n)) * 0.1)));
  const ColorField field(Vec3i(n, n, n), colors);
  const auto paint = field_paint(field, 1.5, {}, false);
  const auto vase = object_solid(*paint, vase_form());
  RenderOptions settings;
  settings.width = settings.height = 512;
  settings.samples = 64;
  const Camera camera = Camera::framing(vase->bounds(), -0.7f, 0.5f, 512, 512);
  for (auto _ : state) benchmark::DoNotOptimize(render(*vase, Studio({}), camera, settings));
}
BENCHMARK(render_vase_64)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace terrazzo
