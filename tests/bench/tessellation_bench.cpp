// Laguerre tessellations with given lognormal volumes, by number, and growth of packed stones. The baseline
// is one Voro++ diagram of the same number of random points with equal weights, on one thread.
#include <benchmark/benchmark.h>

#include <cmath>
#include <voro++/voro++.hh>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/packing/cells/fill_space.h"
#include "nodes/packing/cells/prescribed_volumes.h"
#include "nodes/packing/cells/sphere_seeds.h"
#include "nodes/shapes/shape/stones.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace shape;

void one_run(benchmark::internal::Benchmark* b) { b->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime(); }

void laguerre_volumes(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  const Vec3 box = Vec3::Constant(std::cbrt(static_cast<double>(n)));
  Random random(1);
  std::vector<double> volume;
  for (std::size_t i = 0; i < n; ++i) volume.push_back(std::exp(random.normal()));
  double worst = 0, sum = 0;
  for (auto _ : state) {
    tessellation::Seeds seeds = tessellation::sphere_seeds(box, volume, 1);
    tessellation::Effort effort;
    worst = tessellation::fit_volumes(seeds, volume, 1e-3, effort).worst;
    sum = 0;
    for (const auto& c : tessellation::power_diagram(seeds)) sum += c.volume;
  }
  state.counters["worst"] = worst;
  state.counters["unfilled"] = std::abs(1 - sum / box.prod());
}
BENCHMARK(laguerre_volumes)->Arg(100)->Arg(1000)->Arg(10000)->Arg(100000)->Apply(one_run);

void voro_baseline(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(0));
  const double edge = std::cbrt(n);
  const int blocks = std::max(1, static_cast<int>(edge / 1.7));
  double sum = 0;
  for (auto _ : state) {
    voro::container c(0, edge, 0, edge, 0, edge, blocks, blocks, blocks, true, true, true, 8);
    Random random(2);
    for (int i = 0; i < n; ++i)
      c.put(i, edge * random.uniform(), edge * random.uniform(), edge * random.uniform());
    benchmark::DoNotOptimize(sum = c.sum_cell_volumes());
  }
}
BENCHMARK(voro_baseline)->Arg(100)->Arg(1000)->Arg(10000)->Arg(100000)->Apply(one_run);

void grow_stones(benchmark::State& state) {
  StoneOptions kind;
  kind.kind = SolidKind::Pebble;
  Shapes shapes;
  shapes.shapes = {measure_shape("pebble", stone_mesh(kind))};
  SizeDistribution d;
  const double size = shapes.shapes[0].size();
  d.class_edges = {0.7 * size, 1.3 * size};
  d.shapes = {{-1, 0, {1}, {0}, {0}}};
  d.volume_fraction = 0.01 * static_cast<double>(state.range(0));
  tessellation::FillOptions o;
  o.method = tessellation::Method::Grow;
  o.population.count = 1200;
  o.corrections = 0;
  double worst = 0;
  for (auto _ : state) worst = tessellation::fill_space(d, shapes, o).worst;
  state.counters["worst"] = worst;
}
BENCHMARK(grow_stones)->Arg(70)->Arg(80)->Arg(90)->Apply(one_run);

// Shards over a factor of 35 in size at a fraction of 0.82, as a photograph of a polished breccia gives them:
// the box is bounded, and the effort.
void fill_breccia(benchmark::State& state, tessellation::Method method) {
  StoneOptions kind;
  kind.kind = SolidKind::Shard;
  Shapes shapes;
  for (std::uint64_t k = 0; k < 3; ++k) {
    kind.item = k;
    shapes.shapes.push_back(measure_shape("shard", stone_mesh(kind), 1.0 / 3));
  }
  SizeDistribution d;
  std::vector<double> density;
  for (int k = 0; k <= 12; ++k) d.class_edges.push_back(0.68 * std::pow(35, k / 12.0));
  for (int k = 0; k < 12; ++k) density.push_back(std::pow(d.class_edges[k], -3.2));  // equal volumes, about
  d.shapes = {{-1, 0, density, std::vector<double>(12, 0), std::vector<double>(12, 0)}};
  d.volume_fraction = 0.82;
  tessellation::FillOptions o;
  o.method = method;
  o.population.count = 1200;
  o.grains.roundness = 0.15;
  tessellation::FillResult r;
  for (auto _ : state) r = tessellation::fill_space(d, shapes, o);
  state.counters["particles"] = static_cast<double>(r.particles.count());
  state.counters["effort"] = r.effort;
  state.counters["worst"] = r.worst;
}
BENCHMARK_CAPTURE(fill_breccia, grow, tessellation::Method::Grow)->Apply(one_run);
BENCHMARK_CAPTURE(fill_breccia, laguerre, tessellation::Method::Laguerre)->Apply(one_run);

}  // namespace
}  // namespace terrazzo
