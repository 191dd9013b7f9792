// Shapes from profiles: each method of ShapeEstimate against the fastest one that uses all of its input, and
// `fit` on 200 profiles. Also measured sections per second, against sections without measuring.
#include <benchmark/benchmark.h>

#include "nodes/common/stereology/outline_features.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape_estimate/choose.h"
#include "nodes/shapes/shape_estimate/fit.h"
#include "nodes/shapes/shape_estimate/methods/method.h"

namespace terrazzo {
namespace {
using namespace shape;

using namespace shape_estimate;

const Shapes& one_stone() {
  static const Shapes shapes = [] {
    RockOptions o;
    o.detail = 4;
    o.roughness = 0.008;
    Shapes s;
    s.shapes.push_back(measure_shape("rock", rock_mesh(o)));
    return s;
  }();
  return shapes;
}

const std::vector<Outline>& outlines() {
  static const std::vector<Outline> all = [] {
    Profiles p;
    for (const auto& section : random_sections(one_stone(), 205, {SectionKind::Random, 1, 0}))
      for (const auto& profile : section) {
        Profile q;
        q.contour = profile[0];
        p.profiles.push_back(q);
      }
    auto c = candidates_of(p, {.smallest = 0.1}).outlines;
    if (c.size() > 200) c.resize(200);
    return c;
  }();
  return all;
}

void shape_method(benchmark::State& state, const char* name) {
  for (const auto& m : estimate_methods()) {
    if (m.name != name) continue;
    EstimateRequest r;
    r.chosen = {outlines()[0], outlines()[20], outlines()[60]};
    for (auto _ : state) benchmark::DoNotOptimize(m.run(r, Work()));
  }
}
BENCHMARK_CAPTURE(shape_method, csg, "csg")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(shape_method, spherical_harmonics, "spherical_harmonics")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(shape_method, generalized_cylinder, "generalized_cylinder")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(shape_method, morphed_generalized_cylinder, "morphed_generalized_cylinder")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void shape_fit_200_profiles(benchmark::State& state) {
  FitRequest r;
  r.all = &outlines();
  for (const auto& hand : choose_profiles(outlines(), "representative", 4, 3, 1)) {
    r.hands.emplace_back();
    for (const int i : hand) r.hands.back().push_back(outlines()[static_cast<std::size_t>(i)]);
  }
  r.smallest = 0.1;
  for (auto _ : state) {
    const Fit fit = fit_bodies(r);
    state.counters["distance"] = fit.distance;
    state.counters["start"] = fit.start;
  }
}
BENCHMARK(shape_fit_200_profiles)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Iterations(1);

void shape_sections_measured(benchmark::State& state) {
  for (auto _ : state)
    for (const auto& section : random_sections(one_stone(), 1000, {SectionKind::Random, 1, 0}))
      for (const auto& p : section) benchmark::DoNotOptimize(outline_features(p[0]));
  state.counters["sections"] =
      benchmark::Counter(1000.0 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(shape_sections_measured)->Unit(benchmark::kMillisecond)->UseRealTime();

void shape_sections_alone(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(random_sections(one_stone(), 1000, {SectionKind::Random, 1, 0}));
  state.counters["sections"] =
      benchmark::Counter(1000.0 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(shape_sections_alone)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace terrazzo
