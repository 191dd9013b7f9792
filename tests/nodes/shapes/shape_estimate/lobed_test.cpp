// Lobed and compact particles of different sizes, from their sections.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/sizes/unfolding/model.h"
#include "runtime/codec.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Shapes balls() {
  return terrazzo::test::run_node("Shape", {}, {{"kind", "sphere"}, {"detail", "3"}})
      .output<Shapes>("shapes");
}

// Not the bodies among which ShapeEstimate chooses.
Shapes lobed_bodies(int count) {
  Shapes out;
  for (int i = 0; i < count; ++i)
    out.shapes.push_back(measure_shape("lobed", shape_estimate::lobed_body(99, 7 * i + 3), 1.0 / count));
  return out;
}

// Particles with sizes even between two limits, in mm.
struct Kind {
  Shapes shapes;
  double low, high, fraction;

  Value sizes() const {
    const auto text = [](double v) { return std::to_string(v); };
    return terrazzo::test::run_node("Distribution", {{"shapes", Value::of(shapes)}},
                                    {{"kind", "uniform"},
                                     {"min", text(low)},
                                     {"max", text(high)},
                                     {"volume_fraction", text(fraction)}})
        .outputs.at("distribution");
  }
};

struct Sections {
  Profiles profiles;
  double first = 0, second = 0;  // particles of each kind per mm³
};

// Sections through a packing of two kinds.
Sections sections_of(const Kind& first, const Kind& second) {
  const auto mix = terrazzo::test::run_node("MixDistributions", {{"distributions", first.sizes()},
                                                                 {"distributions", second.sizes()},
                                                                 {"shapes", Value::of(first.shapes)},
                                                                 {"shapes", Value::of(second.shapes)}});
  const auto pack = terrazzo::test::run_node(
      "Pack", {{"distribution", mix.outputs.at("distribution")}, {"shapes", mix.outputs.at("shapes")}},
      {{"method", "anneal"}, {"size", "80"}});
  const auto cut = terrazzo::test::run_node(
      "Section", {{"particles", pack.outputs.at("particles")}, {"shapes", pack.outputs.at("shapes")}},
      {{"planes", "8"}, {"pixel_size", "0.1"}});
  Sections out;
  out.profiles = cut.output<Profiles>("profiles");
  // Colors tell kinds apart in a mixture, but not here.
  for (Profile& p : out.profiles.profiles) p.cls = 0;
  out.profiles.classes = 1;
  const auto& particles = pack.output<Particles>("particles");
  for (const int shape : particles.shape)
    ++(shape < static_cast<int>(first.shapes.shapes.size()) ? out.first : out.second);
  out.first /= particles.box.prod();
  out.second /= particles.box.prod();
  return out;
}

terrazzo::test::NodeRun estimate(const Profiles& profiles, int threads = 0) {
  return terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(profiles)}}, {{"method", "auto"}},
                                  {}, threads);
}

bool is_lobed(const Shape& s) { return s.name.starts_with("lobed"); }

TEST(LobedParticles, AreCountedApartFromRoundOnes) {
  const Sections s = sections_of({balls(), 2, 5, 0.08}, {lobed_bodies(3), 8, 12, 0.25});
  const auto shapes = estimate(s.profiles);
  ASSERT_GT(shapes.metrics.at("lobed"), 0);
  const auto k = terrazzo::test::run_node("KMatrix", {{"shapes", shapes.outputs.at("shapes")}},
                                          {{"classes", "20"}, {"orientations", "500"}});
  const auto unfold = terrazzo::test::run_node(
      "Unfold", {{"profiles", Value::of(s.profiles)}, {"kmatrix", k.outputs.at("kmatrix")}},
      {{"bootstrap", "0"}});
  const auto& sizes = unfold.output<SizeDistribution>("distribution");
  double compact = 0, lobed = 0, large_compact = 0;
  for (const auto& e : sizes.shapes)
    for (std::size_t j = 0; j < sizes.classes(); ++j) {
      const bool is = is_lobed(shapes.output<Shapes>("shapes").shapes[e.shape]);
      (is ? lobed : compact) += e.N_V[j];
      if (!is && sizes.class_edges[j] > 7.5) large_compact += e.N_V[j];
    }
  RecordProperty("compact", std::to_string(compact / s.first));
  RecordProperty("lobed", std::to_string(lobed / s.second));
  RecordProperty("large_compact", std::to_string(large_compact / s.second));
  EXPECT_NEAR(compact / s.first, 1, 0.2);
  EXPECT_NEAR(lobed / s.second, 1, 0.25);
  EXPECT_LT(large_compact, 0.3 * s.second);
}

TEST(LobedParticles, OfAllSizesAreNotAGroup) {
  const Sections s = sections_of({balls(), 4, 10, 0.15}, {lobed_bodies(3), 4, 10, 0.15});
  const auto shapes = estimate(s.profiles);
  EXPECT_EQ(shapes.metrics.at("lobed"), 0);
  EXPECT_FALSE(have_trend(shapes.output<Shapes>("shapes").shapes));
}

TEST(LobedParticles, AreNotFoundAmongRoundOnes) {
  const Sections s = sections_of({balls(), 2, 5, 0.1}, {balls(), 6, 10, 0.2});
  EXPECT_EQ(estimate(s.profiles).metrics.at("lobed"), 0);
}

TEST(LobedParticles, AreTheSameOnAnyNumberOfThreads) {
  const Sections s = sections_of({balls(), 2, 5, 0.05}, {lobed_bodies(3), 8, 12, 0.2});
  const auto one = estimate(s.profiles, 1), seven = estimate(s.profiles, 7);
  ASSERT_GT(one.metrics.at("lobed"), 0);
  const auto &a = one.output<Shapes>("shapes").shapes, &b = seven.output<Shapes>("shapes").shapes;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].probability, b[i].probability);
    EXPECT_EQ(a[i].trend.power, b[i].trend.power);
    EXPECT_EQ(a[i].mesh.vertices, b[i].mesh.vertices);
  }
}

Shapes with_trend() {
  Shapes out = balls();
  out.shapes.push_back(out.shapes[0]);
  for (Shape& s : out.shapes) s.probability = 0.5;
  out.shapes[1].trend = {.power = 3, .size = 4};
  return out;
}

TEST(SizeTrend, SharesFollowThePowerOfTheSize) {
  const auto k =
      terrazzo::test::run_node("KMatrix", {{"shapes", Value::of(with_trend())}}).output<KMatrix>("kmatrix");
  EXPECT_DOUBLE_EQ(unfolding::shape_shares(k, 4)[1], 0.5);
  EXPECT_DOUBLE_EQ(unfolding::shape_shares(k, 8)[1], 8.0 / 9);
  EXPECT_DOUBLE_EQ(unfolding::shape_shares(k, 2)[1], 1.0 / 9);
}

template <class T>
T stored(const T& value) {
  BufferWriter w;
  value_type<T>().encode(&value, w);
  Reader r(w.buffer.data(), w.buffer.size());
  return *static_cast<const T*>(value_type<T>().decode(r).get());
}

TEST(SizeTrend, SurvivesStorageAndFiles) {
  Shapes shapes = with_trend();
  shapes.shapes[1].trend.spread = 0.5;
  const KMatrix k =
      terrazzo::test::run_node("KMatrix", {{"shapes", Value::of(shapes)}}).output<KMatrix>("kmatrix");
  const auto folder = terrazzo::test::temporary_folder();
  terrazzo::test::run_node("Export", {{"shapes", Value::of(shapes)}}, {{"path", "shapes.json"}}, folder);
  terrazzo::test::run_node("Export", {{"kmatrix", Value::of(k)}}, {{"path", "k.json"}}, folder);
  const auto read = [&](const char* type, const char* file) {
    return terrazzo::test::run_node(type, {}, {{"path", (folder / file).string()}});
  };
  const Shapes loaded = read("LoadShapes", "shapes.json").output<Shapes>("shapes");
  const KMatrix again = read("LoadKMatrix", "k.json").output<KMatrix>("kmatrix");
  for (const SizeTrend& t : {stored(shapes).shapes[1].trend, loaded.shapes[1].trend,
                             stored(k).shapes[1].trend, again.shapes[1].trend}) {
    EXPECT_EQ(t.power, 3);
    EXPECT_EQ(t.size, 4);
    EXPECT_EQ(t.spread, 0.5);
  }
  EXPECT_TRUE(loaded.shapes[0].trend.even());
}

}  // namespace
}  // namespace terrazzo
