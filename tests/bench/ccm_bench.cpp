// Color co-occurrence: pixel updates per second (1993: 450 with 5 × 5 and 8 levels), and a dab of a nib of 12
// × 12 pixels. The baseline tries every level of a pixel with the paper's four changes one by one, as written
// in section 3.
#include <benchmark/benchmark.h>

#include <map>

#include "nodes/common/texture/level_descent.h"
#include "nodes/cooccurrence/texture_nib/nib.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

constexpr int kLevels = 8, kSide = 256;  // levels unless a benchmark varies them

// Blotches: every pixel resembles one of its neighbors.
LevelField blotches(int side, int levels = kLevels) {
  LevelField f(Vec3i(side, side, 1));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      Random r(1, 1, f.index(x, y));
      const auto fresh = static_cast<std::uint8_t>(r.below(static_cast<std::uint64_t>(levels)));
      const double u = r.uniform();
      f.at[f.index(x, y)] = u < 0.5 && x > 0    ? f.at[f.index(x - 1, y)]
                            : u < 0.85 && y > 0 ? f.at[f.index(x, y - 1)]
                                                : fresh;
    }
  return f;
}

std::vector<PairTarget> targets(const LevelField& source, const std::vector<Vec3i>& offsets,
                                int levels = kLevels) {
  const Cooccurrence c = measure_cooccurrence(source, levels, offsets, false);
  std::vector<PairTarget> out;
  for (std::size_t d = 0; d < offsets.size(); ++d)
    out.push_back({offsets[d], scaled_counts(c, d, kSide * kSide)});
  return out;
}

void count(benchmark::State& state, double pixels) {
  state.counters["pixel_updates"] = benchmark::Counter(pixels, benchmark::Counter::kIsRate);
}

// Five sweeps, starting from noise.
void ccm_synthesis(benchmark::State& state) {
  const int levels = static_cast<int>(state.range(2));
  const LevelField source = blotches(kSide, levels);
  const auto wanted = targets(
      source, cooccurrence_offsets(static_cast<int>(state.range(0)), static_cast<int>(state.range(1))),
      levels);
  const LevelField noise = level_noise({&source}, levels, source.size, 1);
  double start = 0, end = 0, pixels = 0;
  for (auto _ : state) {
    state.PauseTiming();
    LevelDescent descent(noise, levels, true, wanted);
    start = descent.error();
    state.ResumeTiming();
    for (std::uint64_t k = 0; k < 5; ++k) {
      descent.sweep(k);
      pixels += kSide * kSide;
    }
    end = descent.error();
  }
  count(state, pixels);
  state.counters["error_falls"] = start / end;
}
BENCHMARK(ccm_synthesis)
    ->ArgNames({"extent", "scales", "levels"})
    ->Args({2, 1, 8})
    ->Args({4, 1, 8})
    ->Args({6, 1, 8})
    ->Args({2, 4, 8})
    ->Args({2, 1, 2})
    ->Args({2, 1, 4})
    ->Args({2, 1, 16})
    ->Args({2, 1, 32})
    ->Unit(benchmark::kMillisecond);

void ccm_plain(benchmark::State& state) {
  const int levels = static_cast<int>(state.range(0));
  const std::size_t square = static_cast<std::size_t>(levels) * levels;
  const LevelField source = blotches(kSide, levels);
  const auto offsets = cooccurrence_offsets(2);
  const auto wanted = targets(source, offsets, levels);
  LevelField field = level_noise({&source}, levels, source.size, 1);
  const Cooccurrence now = measure_cooccurrence(field, levels, offsets, true);
  std::vector<std::int32_t> difference = now.counts;
  for (std::size_t d = 0; d < offsets.size(); ++d)
    for (std::size_t i = 0; i < square; ++i) difference[d * square + i] -= wanted[d].counts[i];
  double pixels = 0;
  std::uint64_t at = 0;
  for (auto _ : state) {
    const int x = static_cast<int>(mix64(at) % kSide), y = static_cast<int>(mix64(at + 7) % kSide);
    ++at;
    auto& pixel = field.at[field.index(x, y)];
    const int old = pixel;
    double least = 0;
    int best = old;
    std::map<std::size_t, int> changes;
    for (int t = 0; t < levels; ++t) {
      changes.clear();
      for (std::size_t d = 0; d < offsets.size(); ++d) {
        const auto level = [&](int s) {
          return field.at[field.index((x + s * offsets[d].x() + kSide) % kSide,
                                      (y + s * offsets[d].y() + kSide) % kSide)];
        };
        const std::size_t after = level(1), before = level(-1);
        --changes[d * square + old * levels + after], ++changes[d * square + t * levels + after];
        --changes[d * square + before * levels + old], ++changes[d * square + before * levels + t];
      }
      double delta = 0;
      for (const auto& [entry, by] : changes) delta += (2.0 * difference[entry] + by) * by;
      if (delta < least) {
        least = delta;
        best = t;
      }
    }
    benchmark::DoNotOptimize(pixel = static_cast<std::uint8_t>(best));
    pixel = static_cast<std::uint8_t>(old);
    pixels += 1;
  }
  count(state, pixels);
}
BENCHMARK(ccm_plain)->ArgName("levels")->Arg(4)->Arg(8)->Arg(16)->Arg(32)->Unit(benchmark::kMicrosecond);

// A dab of 12 × 12 pixels in the middle of an image.
void ccm_nib(benchmark::State& state) {
  using namespace texture_nib;
  const LevelField field = blotches(kSide);
  Image picture(kSide, kSide, 1, 1);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] = Vec3f::Constant(0.05f + 0.1f * static_cast<float>(field.at[i]) +
                                        0.04f * static_cast<float>(Random(2, 0, i).uniform()));
  NibOptions s;
  s.extent = static_cast<int>(state.range(0));
  Nib nib(picture, learn(picture, std::vector<std::uint8_t>(picture.pixels.size(), 1), s),
          {.finish = static_cast<Finish>(state.range(1))});
  double pixels = 0;
  int k = 0;
  for (auto _ : state) {
    const int x = 12 * (k % 20), y = 12 * (k / 20 % 20);
    ++k;
    Stroke stroke;
    stroke.area = true;
    stroke.parts = {{Vec2(x, y), Vec2(x + 12, y), Vec2(x + 12, y + 12), Vec2(x, y + 12)}};
    nib.paint(stroke);
    pixels += 4 * 144;
  }
  count(state, pixels);
}
BENCHMARK(ccm_nib)
    ->ArgNames({"extent", "finish"})
    ->Args({2, 0})
    ->Args({3, 0})
    ->Args({3, 1})
    ->Args({3, 2})
    ->Args({6, 2})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace terrazzo
