// Packing of spheres, by number and density, and of stones. The baseline for the same spheres is a plain
// descent of overlaps (each pair is pushed apart by its overlap, neighbors come from a cell grid, one
// thread). `per_particle` is in µs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/packing/rigid/packing.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape/stones.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace shape;

SizeDistribution equal_sizes(const Shapes& shapes, double fraction) {
  const double size = shapes.shapes[0].size();
  SizeDistribution d;
  d.class_edges = {size, size * 1.001};
  d.shapes = {{-1, 0, {fraction / shapes.shapes[0].volume}, {0}, {0}}};
  d.volume_fraction = fraction;
  d.d_max = size;
  return d;
}

// Long runs: wall-clock seconds, one iteration.
void once(benchmark::internal::Benchmark* b) { b->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime(); }

void pack(benchmark::State& state, const Shapes& shapes, std::int64_t count, double fraction) {
  const auto d = equal_sizes(shapes, fraction);
  packing::PackOptions o;
  o.population.count = count;
  o.population.most = 2'000'000;
  double worst = 0;
  for (auto _ : state) worst = packing::pack_particles(d, shapes, nullptr, o).max_penetration;
  state.counters["penetration"] = worst;
  state.counters["per_particle"] =
      benchmark::Counter(static_cast<double>(count) * 1e-6,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

const Shapes& sphere() {
  static const Shapes s = [] {
    Shapes out;
    out.shapes = {measure_shape("sphere", ellipsoid_mesh({1, 1, 1}, 3))};
    return out;
  }();
  return s;
}

void anneal_spheres(benchmark::State& state) {
  pack(state, sphere(), state.range(0), 0.01 * static_cast<double>(state.range(1)));
}
BENCHMARK(anneal_spheres)
    ->Args({1000, 45})
    ->Args({10000, 45})
    ->Args({100000, 45})
    ->Args({1000000, 45})
    ->Args({10000, 55})
    ->Args({10000, 60})
    ->Args({10000, 64})
    ->Args({100000, 59})
    ->Apply(once);

void anneal_stones(benchmark::State& state, SolidKind kind, std::int64_t count, double fraction) {
  Shapes shapes;
  StoneOptions o;
  o.kind = kind;
  shapes.shapes = {measure_shape("stone", o.kind == SolidKind::Rock ? rock_mesh({}) : stone_mesh(o))};
  pack(state, shapes, count, fraction);
}
BENCHMARK_CAPTURE(anneal_stones, rock, SolidKind::Rock, 4000, 0.5)->Apply(once);
BENCHMARK_CAPTURE(anneal_stones, shard, SolidKind::Shard, 4000, 0.5)->Apply(once);
BENCHMARK_CAPTURE(anneal_stones, pebble, SolidKind::Pebble, 4000, 0.5)->Apply(once);
BENCHMARK_CAPTURE(anneal_stones, clinker, SolidKind::Clinker, 3500, 0.44)->Apply(once);

// The baseline.
void overlap_descent(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  const double fraction = 0.01 * static_cast<double>(state.range(1));
  const double edge = std::cbrt(static_cast<double>(n) * M_PI / 6 / fraction);  // diameters of 1
  double deepest = 1;
  int steps = 0;
  for (auto _ : state) {
    std::vector<Vec3> at(n), push(n);
    Random random(1, 0, 0);
    for (auto& p : at) p = Vec3(random.uniform(), random.uniform(), random.uniform()) * edge;
    const int cells = static_cast<int>(edge);
    std::vector<std::int32_t> first(static_cast<std::size_t>(cells) * cells * cells), next(n);
    const auto cell = [&](double x) { return std::min(cells - 1, static_cast<int>(x / edge * cells)); };
    deepest = 1;
    for (steps = 0; deepest > 1e-4 && steps < 20000; ++steps) {
      std::fill(first.begin(), first.end(), -1);
      for (std::size_t i = 0; i < n; ++i) {
        auto& head = first[(static_cast<std::size_t>(cell(at[i].z())) * cells + cell(at[i].y())) * cells +
                           cell(at[i].x())];
        next[i] = head;
        head = static_cast<std::int32_t>(i);
      }
      std::fill(push.begin(), push.end(), Vec3::Zero());
      deepest = 0;
      for (std::size_t i = 0; i < n; ++i)
        for (int dz = -1; dz <= 1; ++dz)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
              const auto wrap = [&](int c) { return (c + cells) % cells; };
              const std::size_t c = (static_cast<std::size_t>(wrap(cell(at[i].z()) + dz)) * cells +
                                     wrap(cell(at[i].y()) + dy)) *
                                        cells +
                                    wrap(cell(at[i].x()) + dx);
              for (std::int32_t j = first[c]; j >= 0; j = next[j]) {
                if (static_cast<std::size_t>(j) <= i) continue;
                Vec3 v = at[j] - at[i];
                for (int a = 0; a < 3; ++a) v[a] -= std::round(v[a] / edge) * edge;
                const double distance = v.norm();
                if (distance >= 1 || distance == 0) continue;
                deepest = std::max(deepest, 1 - distance);
                const Vec3 half = v * (0.5 * (1.0001 - distance) / distance);
                push[i] -= half;
                push[j] += half;
              }
            }
      for (std::size_t i = 0; i < n; ++i)
        for (int a = 0; a < 3; ++a) {
          at[i][a] += push[i][a];
          at[i][a] -= std::floor(at[i][a] / edge) * edge;
          if (!(at[i][a] < edge)) at[i][a] = 0;
        }
    }
  }
  state.counters["penetration"] = deepest;
  state.counters["steps"] = steps;
}
BENCHMARK(overlap_descent)->Args({10000, 45})->Args({10000, 55})->Apply(once);

}  // namespace
}  // namespace terrazzo
