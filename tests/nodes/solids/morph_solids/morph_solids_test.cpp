#include "nodes/solids/morph_solids/morph_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/common/texture/color.h"
#include "nodes/solids/patch_fill/color_morph.h"
#include "nodes/solids/patch_fill/finish.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace morph_solids;
using namespace patch_fill;

constexpr int kSize = 32;

// Waves with random directions and phases, of `turns` periods per edge. `flat`: none varies along x.
Torus<Vec3f> waves(int turns, bool flat, const Vec3f& dark, const Vec3f& light, std::uint64_t seed) {
  Torus<Vec3f> out(Vec3i::Constant(kSize), Vec3f::Zero());
  constexpr int kWaves = 12;
  Random random(seed);
  std::vector<Vec3> k;
  std::vector<double> phase;
  while (k.size() < kWaves) {
    Vec3 v;
    for (int a = 0; a < 3; ++a)
      v[a] = static_cast<double>(random.below(static_cast<std::uint64_t>(2 * turns + 1))) - turns;
    if (flat) v.x() = 0;
    if (v.norm() < 0.7 * turns || v.norm() > 1.3 * turns) continue;
    k.push_back(v);
    phase.push_back(random.uniform(0, 2 * std::numbers::pi));
  }
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    double sum = 0;
    for (std::size_t w = 0; w < k.size(); ++w)
      sum += std::cos(2 * std::numbers::pi * k[w].dot(out.place(i).cast<double>()) / kSize + phase[w]);
    out.at[i] = dark + static_cast<float>(0.5 + 0.5 * std::tanh(sum / 2)) * (light - dark);
  }
  return out;
}

// Bright isotropic blobs, and darker fibers along x.
Torus<Vec3f> blobs() { return waves(3, false, Vec3f::Constant(0.2f), Vec3f::Constant(0.9f), 3); }
Torus<Vec3f> fibers() { return waves(4, true, Vec3f::Constant(0.01f), Vec3f::Constant(0.5f), 4); }

std::vector<double> lightness(const Torus<Vec3f>& t) {
  std::vector<double> out;
  for (const Vec3f& c : t.at) out.push_back(linear_to_oklab(c)[0]);
  return out;
}

double quantile(std::vector<double> v, double u) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(u * static_cast<double>(v.size() - 1))];
}

double deviation(const std::vector<double>& v) {
  double sum = 0, square = 0;
  for (const double x : v) {
    sum += x;
    square += x * x;
  }
  const double n = static_cast<double>(v.size());
  return std::sqrt(square / n - sum * sum / n / n);
}

// Mean absolute step of the lightness along an axis.
double roughness(const Torus<Vec3f>& t, int axis) {
  const std::vector<double> v = lightness(t);
  double sum = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    Vec3i p = t.place(i);
    p[axis] = wrapped(p[axis] + 1, t.size[axis]);
    sum += std::abs(v[t.index(p.x(), p.y(), p.z())] - v[i]);
  }
  return sum / static_cast<double>(v.size());
}

Torus<Vec3f> at_weight(float w) {
  return morph(blobs(), fibers(), Torus<float>(Vec3i::Constant(kSize), w), {}, Work()).color;
}

Volume volume_of(const Torus<Vec3f>& t, bool periodic = true) {
  Volume v;
  if (periodic) v.resolution = t.size;
  add_vector_grid(v, "Cd", t.size, 0.5, Work(), [&](std::size_t i) { return t.at[i]; });
  return v;
}

std::vector<Vec3f> colors_of(const Volume& v) {
  const VoxelBox box = voxel_box(v);
  std::vector<Vec3f> out(box.count());
  VoxelSource(v, "Cd", box).read(0, box.size.z(), out.data());
  return out;
}

TEST(MorphSolids, IsOneOfTheSolidsAtWeights0And1) {
  EXPECT_EQ(at_weight(0).at, blobs().at);
  EXPECT_EQ(at_weight(1).at, fibers().at);
}

TEST(MorphSolids, TransportsTheHistogram) {
  const auto a = lightness(blobs()), b = lightness(fibers());
  for (const float w : {0.25f, 0.5f, 0.75f}) {
    const auto between = lightness(at_weight(w));
    for (const double u : {0.05, 0.25, 0.5, 0.75, 0.95}) {
      const double from = quantile(a, u), to = quantile(b, u);
      EXPECT_NEAR(quantile(between, u), from + w * (to - from), 0.05 * std::abs(to - from))
          << "weight " << w << ", quantile " << u;
    }
  }
}

// Two unrelated textures faded into each other lose contrast.
TEST(MorphSolids, KeepsTheContrastThatACrossFadeLoses) {
  const Torus<Vec3f> a = blobs(), b = fibers();
  const double mean = 0.5 * (deviation(lightness(a)) + deviation(lightness(b)));
  Torus<Vec3f> faded = a;
  for (std::size_t i = 0; i < a.at.size(); ++i)
    faded.at[i] = oklab_to_linear(0.5f * linear_to_oklab(a.at[i]) + 0.5f * linear_to_oklab(b.at[i]));
  EXPECT_LT(deviation(lightness(faded)), 0.8 * mean);
  EXPECT_GT(deviation(lightness(at_weight(0.5))), 0.95 * mean);
}

// A field of weight 0.5 between a texture and itself, whose voxels were averaged with their neighbors.
TEST(MorphSolids, RestoresDetail) {
  Torus<Vec3f> grain(Vec3i::Constant(kSize), Vec3f::Zero());
  for (std::size_t i = 0; i < grain.at.size(); ++i)
    grain.at[i] = Vec3f::Constant(static_cast<float>(Random(7, 0, i).uniform()));
  Torus<Vec3f> field = grain;
  for (std::size_t i = 0; i < field.at.size(); ++i) {
    const Vec3i p = grain.place(i);
    const Vec3f& before = grain.at[grain.index(wrapped(p.x() - 1, kSize), p.y(), p.z())];
    const Vec3f& after = grain.at[grain.index(wrapped(p.x() + 1, kSize), p.y(), p.z())];
    field.at[i] = 0.7f * grain.at[i] + 0.15f * (before + after);
  }
  const auto step = [](const Torus<Vec3f>& t) {
    double sum = 0;
    for (std::size_t i = 1; i < t.at.size(); ++i) sum += std::abs(t.at[i][0] - t.at[i - 1][0]);
    return sum / static_cast<double>(t.at.size());
  };
  EXPECT_LT(step(field), 0.7 * step(grain));
  const Torus<float> weight(grain.size, 0.5f);
  restore_detail({grain, grain}, weight, Torus<float>(grain.size, 1), field, Work());
  EXPECT_NEAR(step(field) / step(grain), 0.9, 0.1);
}

// How far structures reach along x compared with y and z changes from one solid to the other.
TEST(MorphSolids, ChangesTheStructure) {
  const auto along = [](const Torus<Vec3f>& t) {
    return 2 * roughness(t, 0) / (roughness(t, 1) + roughness(t, 2));
  };
  const double a = along(blobs()), b = along(fibers());
  ASSERT_GT(a, 0.7);
  ASSERT_LT(b, 1e-3);
  const double quarter = along(at_weight(0.25)), half = along(at_weight(0.5)), most = along(at_weight(0.9f));
  EXPECT_LT(half, 0.9 * a);
  EXPECT_LT(half, quarter);
  EXPECT_LT(most, 0.6 * half);
}

TEST(MorphSolids, ContinuesBothSolids) {
  const Torus<Vec3f> a = blobs(), b = fibers();
  Torus<float> weight(a.size, 0);
  for (std::size_t i = 0; i < weight.at.size(); ++i) {
    const int y = weight.place(i).y();
    weight.at[i] = std::clamp(static_cast<float>(12 - std::abs(y - 16)) / 8, 0.0f, 1.0f);
  }
  const Torus<Vec3f> out = morph(a, b, weight, {}, Work()).color;
  std::vector<double> step(kSize), count(kSize);
  const auto v = lightness(out);
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Vec3i p = out.place(i);
    if (weight.at[i] <= 0) {
      EXPECT_EQ(out.at[i], a.at[i]);
    }
    if (weight.at[i] >= 1) {
      EXPECT_EQ(out.at[i], b.at[i]);
    }
    step[static_cast<std::size_t>(p.y())] +=
        std::abs(v[out.index(p.x(), wrapped(p.y() + 1, kSize), p.z())] - v[i]) / (kSize * kSize);
  }
  // Random texels would make steps of about the standard deviation.
  const double rough = std::max(roughness(a, 1), roughness(b, 1));
  for (int y = 0; y < kSize; ++y) EXPECT_LT(step[static_cast<std::size_t>(y)], 1.6 * rough) << "plane " << y;
}

TEST(MorphSolids, ColorsComeBack) {
  const Torus<Vec3f> a = waves(3, false, Vec3f(0.5f, 0.1f, 0.1f), Vec3f(0.9f, 0.8f, 0.6f), 5),
                     b = waves(4, true, Vec3f(0.05f, 0.1f, 0.3f), Vec3f(0.2f, 0.6f, 0.9f), 6);
  const ColorMorph colors(a.at, b.at);
  for (std::size_t i = 0; i < a.at.size(); i += 97) {
    EXPECT_LT((colors.to_linear(colors.to_working(0, a.at[i]), 0) - a.at[i]).cwiseAbs().maxCoeff(), 0.01f);
    EXPECT_LT((colors.to_linear(colors.to_working(1, b.at[i]), 1) - b.at[i]).cwiseAbs().maxCoeff(), 0.01f);
  }
  // Light corresponds to light.
  EXPECT_GT(colors.to_linear(colors.to_working(0, Vec3f(0.9f, 0.8f, 0.6f)), 1).sum(), 1.5f);
}

TEST(MorphSolids, TakesWeightsFromAVolume) {
  const Torus<Vec3f> a = blobs(), b = fibers();
  Volume weights;
  weights.resolution = a.size;
  add_number_grid(weights, "share", a.size, Vec3::Constant(0.5), Work(),
                  [](std::size_t i) { return i % kSize < kSize / 2 ? 0.0f : 1.0f; });
  const auto run = test::run_node(
      "MorphSolids",
      {{"a", Value::of(volume_of(a))}, {"b", Value::of(volume_of(b))}, {"weights", Value::of(weights)}});
  const auto out = colors_of(run.output<Volume>("volume"));
  for (std::size_t i = 0; i < out.size(); ++i)
    ASSERT_EQ(out[i], i % kSize < kSize / 2 ? a.at[i] : b.at[i]) << i;
  EXPECT_EQ(run.metrics.at("synthesized"), 0);
}

TEST(MorphSolids, RejectsWhatDoesNotFit) {
  const auto code = [](const Volume& a, const Volume& b, const Volume* weights = nullptr) {
    return test::code_of([&] {
      std::multimap<std::string, Value> inputs = {{"a", Value::of(a)}, {"b", Value::of(b)}};
      if (weights) inputs.emplace("weights", Value::of(*weights));
      test::run_node("MorphSolids", inputs);
    });
  };
  const Volume a = volume_of(blobs());
  const Torus<Vec3f> thin(Vec3i(32, 32, 8), Vec3f::Zero()), small(Vec3i(32, 32, 16), Vec3f::Zero());
  EXPECT_EQ(code(a, volume_of(small)), "size-mismatch");
  EXPECT_EQ(code(volume_of(thin), volume_of(thin)), "too-small");
  EXPECT_EQ(code(a, volume_of(fibers(), false)), "not-periodic");
  EXPECT_EQ(code(a, volume_of(Torus<Vec3f>(Vec3i::Constant(kSize), Vec3f::Constant(0.5f)))), "one-color");
  Volume weights;
  weights.resolution = Vec3i::Constant(kSize);
  add_number_grid(weights, "share", weights.resolution, Vec3::Constant(0.5), Work(),
                  [](std::size_t) { return 1.5f; });
  EXPECT_EQ(code(a, volume_of(fibers()), &weights), "bad-values");
  EXPECT_EQ(code(a, volume_of(fibers()), &a), "not-a-scalar");
  EXPECT_EQ(code(weights, a), "no-color");
}

}  // namespace
}  // namespace terrazzo
