// Section statistics of a convex mesh of 5,120 triangles: all depths of a direction at once, against one plane at a time.
#include <benchmark/benchmark.h>

#include "nodes/common/mesh_section.h"
#include "nodes/common/shape_measures.h"
#include "nodes/kmatrix/section_statistics.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

// An icosahedron divided four times, its vertices on an ellipsoid.
Mesh ellipsoid_mesh() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Mesh m;
  m.vertices = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g},
                {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  m.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                 {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
  for (int level = 0; level < 4; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto half = [&](int a, int b) {
      const auto key = std::minmax(a, b);
      if (const auto it = middle.find(key); it != middle.end()) return it->second;
      m.vertices.push_back((m.vertices[static_cast<std::size_t>(a)] + m.vertices[static_cast<std::size_t>(b)]) / 2);
      return middle[key] = static_cast<int>(m.vertices.size()) - 1;
    };
    std::vector<Triangle> next;
    for (const auto& t : m.triangles) {
      const int a = half(t[0], t[1]), b = half(t[1], t[2]), c = half(t[2], t[0]);
      next.insert(next.end(), {Triangle{t[0], a, c}, Triangle{t[1], b, a}, Triangle{t[2], c, b}, Triangle{a, b, c}});
    }
    m.triangles = std::move(next);
  }
  for (auto& v : m.vertices) v = v.normalized().cwiseProduct(Vec3(1, 0.8, 0.6));
  return m;
}

void kmatrix_all_depths(benchmark::State& state) {
  const Shape shape = measure_shape("ellipsoid", ellipsoid_mesh());
  for (auto _ : state) benchmark::DoNotOptimize(slice_statistics(shape, 10, 0));
}
BENCHMARK(kmatrix_all_depths)->Unit(benchmark::kMillisecond);

// The baseline: random planes, each section's loops made and measured.
void kmatrix_one_plane_at_a_time(benchmark::State& state) {
  const Mesh mesh = ellipsoid_mesh();
  std::uint64_t item = 0;
  for (auto _ : state) {
    Random random(1, 0, ++item);
    const Mat3 frame = Quat(random.normal(), random.normal(), random.normal(), random.normal()).normalized().toRotationMatrix();
    double area = 0;
    for (const auto& loop : section_loops(mesh, frame, random.uniform(-0.6, 0.6))) area += loop_area(loop);
    benchmark::DoNotOptimize(area);
  }
  state.counters["slices"] = benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(kmatrix_one_plane_at_a_time)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace terrazzo
