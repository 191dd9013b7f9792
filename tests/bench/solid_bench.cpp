// Solid textures: the default method (coherence search) against the reference method of Laursen, Ersbøll and
// Bærentzen 2011 (nearest neighbors from a tree, their weights and schedule), both on one core with the same
// exemplar. `times` is the CPU time of the reference method over that of the default method. The other
// counters are measures of the slices on the worst axis, in the same units for both; the ideal is 1 for
// `finest` and 0 for `patches`, `histogram` and `copied`.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "nodes/detail/residual_synth/synthesize.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "tests/bench/blobs.h"

namespace terrazzo {
namespace {
using namespace residual_synth;
namespace so = solids;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Made {
  double seconds, patches = 0, histogram = 0, finest = 1, copied = 0;
};

Made make(int side, bool reference, bool blockwise = false) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  so::SolidOptions s;
  s.size = Vec3i::Constant(side);
  if (reference) s.method = so::SolidMethod::Reference;
  if (reference) {
    s.iterations = {100, 20, 10};
    s.color = so::SolidColor::Rgb;
  }
  if (blockwise) {
    s.method = so::SolidMethod::Blockwise;
    s.finish = 1;
  }
  const double start = cpu_seconds();
  const auto r = so::optimize_solid({bench::blobs(side)}, s, Work());
  Made m{cpu_seconds() - start};
  for (const auto& p : r.measures) {
    m.patches = std::max(m.patches, p.patches);
    m.histogram = std::max(m.histogram, p.histogram);
    m.copied = std::max(m.copied, p.copied_worst);
    if (std::abs(p.bands[0] - 1) > std::abs(m.finest - 1)) m.finest = p.bands[0];
  }
  return m;
}

void tell(benchmark::State& state, const Made& m) {
  state.counters["cpu_s"] = m.seconds, state.counters["patches"] = m.patches;
  state.counters["histogram"] = m.histogram, state.counters["finest"] = m.finest;
  state.counters["copied"] = m.copied;
}

void solid_papers_beside_coherence(benchmark::State& state) {
  Made ours{0}, theirs{0};
  for (auto _ : state) {
    theirs = make(static_cast<int>(state.range(0)), true);
    ours = make(static_cast<int>(state.range(0)), false);
  }
  tell(state, ours);
  state.counters["papers_cpu_s"] = theirs.seconds, state.counters["papers_patches"] = theirs.patches;
  state.counters["papers_histogram"] = theirs.histogram, state.counters["papers_finest"] = theirs.finest;
  state.counters["papers_copied"] = theirs.copied;
  state.counters["times"] = theirs.seconds / ours.seconds;
}
// Size 128 takes four minutes.
BENCHMARK(solid_papers_beside_coherence)->Arg(32)->Arg(64)->Arg(128)->Iterations(1)->Unit(benchmark::kSecond);

void solid_coherence(benchmark::State& state) {
  Made m{0};
  for (auto _ : state) m = make(static_cast<int>(state.range(0)), false);
  tell(state, m);
}
BENCHMARK(solid_coherence)->Arg(64)->Arg(128)->Iterations(1)->Unit(benchmark::kSecond);

// The same with the blockwise method, whose passes see only a bounded neighborhood.
void solid_local(benchmark::State& state) {
  Made m{0};
  for (auto _ : state) m = make(static_cast<int>(state.range(0)), false, true);
  tell(state, m);
}
BENCHMARK(solid_local)->Arg(64)->Arg(128)->Iterations(1)->Unit(benchmark::kSecond);

// The residual of grain of several sizes along one color axis, on all cores.
void solid_residual(benchmark::State& state) {
  const auto e = bench::blobs(256);
  Image image(256, 256, 1, 1);
  image.pixels = e.pixels;
  Vec3f mean = Vec3f::Zero();
  for (const auto& p : image.pixels) mean += p / static_cast<float>(image.pixels.size());
  for (auto& p : image.pixels) p -= mean;
  const Exemplar exemplar = measure_exemplar({image}, {0, 0, 0}, 4, 4);
  const int side = static_cast<int>(state.range(0));
  double worst = 1;
  for (auto _ : state) {
    const auto v = synthesize_residual(exemplar, Vec3i::Constant(side), 2, 1);
    state.PauseTiming();
    for (const double d : slice_deviations(exemplar, Vec3i::Constant(side), v))
      if (std::abs(d - 1) > std::abs(worst - 1)) worst = d;
    state.ResumeTiming();
  }
  state.counters["worst_band"] = worst, state.counters["color_axes"] = exemplar.channels;
}
BENCHMARK(solid_residual)->Arg(64)->Arg(128)->Iterations(1)->UseRealTime()->Unit(benchmark::kSecond);

}  // namespace
}  // namespace terrazzo
