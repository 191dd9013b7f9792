// Section statistics of a convex mesh of 5,120 triangles: all depths of a direction together, against one
// plane at a time, as loops and as pixels of a stencil buffer. `slices` counts planes per second; for the
// first method, it counts the depths with exact areas (97 per direction). `worst_class` is the largest
// deviation of the default effort from a long run.
#include <benchmark/benchmark.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "nodes/sizes/kmatrix/stencil_slicer.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace shape;

const Shape& body() {
  static const Shape shape = measure_shape("ellipsoid", ellipsoid_mesh({1, 0.8, 0.6}, 4));
  return shape;
}

double share(const SectionStatistics& s, int k) {
  const auto at = [&](int c) {
    return c == 0 ? 0.0 : s.cdf[static_cast<std::size_t>(c * kSectionBins / 10 - 1)];
  };
  return at(k + 1) - at(k);
}

void kmatrix_all_depths(benchmark::State& state) {
  static const SectionStatistics long_run = slice_statistics(body(), 10, 20000);
  SectionStatistics s;
  for (auto _ : state) s = slice_statistics(body(), 10, 0);
  double worst = 0;
  for (int k = 0; k < 10; ++k) worst = std::max(worst, std::abs(share(s, k) / share(long_run, k) - 1));
  state.counters["worst_class"] = worst;
  state.counters["slices"] = benchmark::Counter(static_cast<double>(state.iterations() * s.orientations * 97),
                                                benchmark::Counter::kIsRate);
}
BENCHMARK(kmatrix_all_depths)->Unit(benchmark::kMillisecond)->UseRealTime();

// Extracts and measures the loops of random sections.
void kmatrix_one_plane_at_a_time(benchmark::State& state) {
  std::uint64_t item = 0;
  for (auto _ : state) {
    Random random(1, 0, ++item);
    const Mat3 frame = Quat(random.normal(), random.normal(), random.normal(), random.normal())
                           .normalized()
                           .toRotationMatrix();
    double area = 0;
    for (const auto& loop : section_loops(body().mesh, frame, random.uniform(-0.6, 0.6)))
      area += loop_area(loop);
    benchmark::DoNotOptimize(area);
  }
  state.counters["slices"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(kmatrix_one_plane_at_a_time)->Unit(benchmark::kMicrosecond)->UseRealTime();

void kmatrix_stencil(benchmark::State& state) {
  constexpr std::size_t kSlices = 1024;
  try {
    EglContext probe(GlDevice::Cpu);
  } catch (const Error& e) {
    state.SkipWithError(e.what());
    return;
  }
  for (auto _ : state) benchmark::DoNotOptimize(stencil_statistics(body(), 10, kSlices, GlDevice::Cpu));
  state.counters["slices"] =
      benchmark::Counter(static_cast<double>(state.iterations() * kSlices), benchmark::Counter::kIsRate);
}
BENCHMARK(kmatrix_stencil)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace terrazzo
