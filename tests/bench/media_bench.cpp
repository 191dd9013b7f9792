// Solids of phases: MediaSolid beside SolidOptimize's method on the same picture of two phases, whose gray
// solid is cut at the level that gives the picture's fraction. `surface` is the area of the interface over
// the picture's; the ideal is 1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>

#include "nodes/data/indices.h"
#include "nodes/media/annealing/anneal.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "tests/bench/blobs.h"

namespace terrazzo {
namespace {

constexpr int kPictureSide = 256;  // of the picture, pixels

media::PhaseMap picture() {
  const solids::SolidExemplar blobs = bench::blobs(kPictureSide);
  media::PhaseMap out{kPictureSide, kPictureSide, 2, 1, {}};
  for (const Vec3f& c : blobs.pixels) out.at.push_back(c[0] > 0.5f);
  return out;
}

// Pairs of neighbors along x and y in different phases, per pixel and direction.
template <class At>
double surface_of(const At& at, int nx, int ny) {
  double pairs = 0;
  for (int y = 0; y < ny - 1; ++y)
    for (int x = 0; x < nx - 1; ++x) pairs += (at(x, y) != at(x + 1, y)) + (at(x, y) != at(x, y + 1));
  return pairs / (2.0 * (nx - 1) * (ny - 1));
}

// Mean over all slices across z, over the picture's.
double relative_surface(const std::vector<std::uint8_t>& phase, int n, const media::PhaseMap& map) {
  double sum = 0;
  for (int z = 0; z < n; ++z)
    sum += surface_of([&](int x, int y) { return phase[voxel_at(x, y, z, Vec3i::Constant(n))]; }, n, n);
  return sum / n / surface_of([&](int x, int y) { return map.at[map.index(x, y)]; }, map.width, map.height);
}

// The brightest voxels, as many as the picture has pixels in the second phase.
std::vector<std::uint8_t> cut(const solids::SolidResult& solid, double fraction) {
  const float sign = solid.axes.to(Vec3f::Ones())[0] > solid.axes.to(Vec3f::Zero())[0] ? 1.0f : -1.0f;
  std::vector<float> gray = solid.field.channel[0];
  for (float& g : gray) g *= sign;
  std::vector<float> sorted = gray;
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>((1 - fraction) * (sorted.size() - 1));
  std::nth_element(sorted.begin(), at, sorted.end());
  std::vector<std::uint8_t> out;
  for (const float g : gray) out.push_back(g > *at);
  return out;
}

double cpu_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void media_beside_solid_texture(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const media::PhaseMap map = picture();
  solids::SolidExemplar exemplar;
  exemplar.width = exemplar.height = kPictureSide;
  for (const std::uint8_t p : map.at) exemplar.pixels.push_back(Vec3f::Constant(p ? 0.8f : 0.1f));
  for (auto _ : state) {
    double start = cpu_now();
    annealing::AnnealOptions options;
    options.size = Vec3i::Constant(n);
    const auto ours = annealing::synthesize({map}, options, {});
    const double seconds = cpu_now() - start;
    start = cpu_now();
    solids::SolidOptions texture;
    texture.size = Vec3i::Constant(n);
    const auto theirs = solids::optimize_solid({exemplar}, texture, {});
    const double texture_seconds = cpu_now() - start;
    state.counters["cpu_s"] = seconds;
    state.counters["times"] = texture_seconds / seconds;
    state.counters["surface"] = relative_surface(ours.phase, n, map);
    state.counters["texture_surface"] = relative_surface(cut(theirs, fractions_of(map)[1]), n, map);
  }
}
BENCHMARK(media_beside_solid_texture)->Arg(64)->Arg(128)->Iterations(1)->Unit(benchmark::kSecond);

// All cores.
void media_solid_of(benchmark::State& state) {
  const media::PhaseMap map = picture();
  annealing::AnnealOptions options;
  options.size = Vec3i::Constant(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(annealing::synthesize({map}, options, {}));
}
BENCHMARK(media_solid_of)->Arg(128)->Arg(256)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace
}  // namespace terrazzo
