// Conductivity, stiffness and permeability of overlapping balls. The baseline for conductivity is conjugate
// gradients on the same equations, scaled by the diagonal, on one thread.
#include <benchmark/benchmark.h>

#include <cmath>

#include "nodes/properties/homogenize/conduction.h"
#include "nodes/properties/homogenize/elasticity.h"
#include "nodes/properties/homogenize/flow.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace homogenize;

constexpr std::array<bool, 3> kX{true, false, false};
constexpr Accuracy kAccuracy{1e-5, 100'000};
constexpr std::uint64_t kPlenty = 1ull << 36;

// Phase 1: balls with a radius of 0.08 edges, of which `count` overlap.
PhaseMap balls(int n, int count) {
  PhaseMap map;
  map.box.size = Vec3i::Constant(n);
  map.box.periodic = true;
  map.phase.assign(voxels_in(map.box.size), 0);
  const double radius = 0.08 * n;
  for (int b = 0; b < count; ++b) {
    Random r(1, 1, static_cast<std::uint64_t>(b));
    const Vec3 center = n * Vec3(r.uniform(), r.uniform(), r.uniform());
    const Vec3i low = (center.array() - radius).floor().cast<int>(),
                high = (center.array() + radius).ceil().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x)
          if ((Vec3(x, y, z) + Vec3::Constant(0.5) - center).norm() < radius)
            map.phase[voxel_at((x + n) % n, (y + n) % n, (z + n) % n, map.box.size)] = 1;
  }
  double inside = 0;
  for (const std::uint8_t p : map.phase) inside += p;
  const double share = inside / static_cast<double>(map.phase.size());
  map.names = {"0", "1"};
  map.fraction = {1 - share, share};
  return map;
}

void one_solution(benchmark::internal::Benchmark* b) {
  b->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();
}

void conductivity(benchmark::State& state) {
  const PhaseMap map = balls(static_cast<int>(state.range(0)), 150);
  Solved s;
  for (auto _ : state)
    s = conduct(map, {1, static_cast<double>(state.range(1))}, Boundary::Periodic, kX, kAccuracy, kPlenty,
                {});
  state.counters["iterations"] = s.iterations;
  state.counters["effective"] = s.effective(0, 0);
}
BENCHMARK(conductivity)
    ->Args({64, 20})
    ->Args({64, 1000})
    ->Args({128, 20})
    ->Args({128, 1000})
    ->Args({256, 1000})
    ->Apply(one_solution);

// A x, where `k` is the conductivity of each voxel.
struct Plain {
  int n;
  std::vector<float> g[3];
  std::vector<double> diagonal;

  Plain(const PhaseMap& map, double contrast) : n(map.box.size.x()), diagonal(map.phase.size(), 0) {
    const auto k = [&](std::size_t i) { return map.phase[i] ? contrast : 1.0; };
    for (int a = 0; a < 3; ++a) g[a].resize(map.phase.size());
    each([&](int a, std::size_t i, std::size_t j) {
      g[a][i] = static_cast<float>(2 / (1 / k(i) + 1 / k(j)));
      diagonal[i] += g[a][i];
      diagonal[j] += g[a][i];
    });
  }
  template <class F>
  void each(F&& f) const {
    const Vec3i size = Vec3i::Constant(n);
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
          const std::size_t i = voxel_at(x, y, z, size);
          f(0, i, voxel_at(x + 1 == n ? 0 : x + 1, y, z, size));
          f(1, i, voxel_at(x, y + 1 == n ? 0 : y + 1, z, size));
          f(2, i, voxel_at(x, y, z + 1 == n ? 0 : z + 1, size));
        }
  }
};

void conductivity_baseline(benchmark::State& state) {
  const PhaseMap map = balls(static_cast<int>(state.range(0)), 150);
  int iterations = 0;
  double effective = 0;
  for (auto _ : state) {
    const Plain m(map, static_cast<double>(state.range(1)));
    const std::size_t n = map.phase.size();
    std::vector<double> x(n, 0), r(n, 0), p(n, 0), q(n);
    m.each([&](int a, std::size_t i, std::size_t j) {
      if (a != 0) return;
      r[i] += m.g[0][i];
      r[j] -= m.g[0][i];
    });
    const auto dot = [&](auto&& f) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += f(i);
      return sum;
    };
    const double whole = dot([&](std::size_t i) { return r[i] * r[i]; });
    double before = 0;
    for (iterations = 0; dot([&](std::size_t i) { return r[i] * r[i]; }) > 1e-10 * whole; ++iterations) {
      const double rz = dot([&](std::size_t i) { return r[i] * r[i] / m.diagonal[i]; });
      for (std::size_t i = 0; i < n; ++i)
        p[i] = r[i] / m.diagonal[i] + (iterations > 0 ? rz / before : 0) * p[i];
      before = rz;
      std::fill(q.begin(), q.end(), 0);
      m.each([&](int a, std::size_t i, std::size_t j) {
        const double flow = m.g[a][i] * (p[i] - p[j]);
        q[i] += flow;
        q[j] -= flow;
      });
      const double alpha = rz / dot([&](std::size_t i) { return p[i] * q[i]; });
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
      }
    }
    effective = 0;
    m.each([&](int a, std::size_t i, std::size_t j) {
      if (a == 0) effective += m.g[0][i] * (x[j] - x[i] + 1) / static_cast<double>(n);
    });
  }
  state.counters["iterations"] = iterations;
  state.counters["effective"] = effective;
}
BENCHMARK(conductivity_baseline)->Args({64, 20})->Args({64, 1000})->Args({128, 20})->Apply(one_solution);

void stiffness_of_balls(benchmark::State& state) {
  const PhaseMap map = balls(static_cast<int>(state.range(0)), 150);
  SolvedStiffness s;
  for (auto _ : state)
    s = stiffness(map, {{1, 0.3}, {static_cast<double>(state.range(1)), 0.2}}, kAccuracy, kPlenty, {});
  state.counters["iterations"] = s.iterations;
}
BENCHMARK(stiffness_of_balls)->Args({64, 100})->Args({128, 100})->Args({64, 0})->Apply(one_solution);

void permeability_around_balls(benchmark::State& state) {
  const PhaseMap map = balls(static_cast<int>(state.range(0)), 600);
  Solved s;
  for (auto _ : state) s = permeate(map, {1, 0}, Boundary::Periodic, kX, kAccuracy, kPlenty, {});
  state.counters["iterations"] = s.iterations;
}
BENCHMARK(permeability_around_balls)->Arg(64)->Arg(128)->Apply(one_solution);

}  // namespace
}  // namespace terrazzo
