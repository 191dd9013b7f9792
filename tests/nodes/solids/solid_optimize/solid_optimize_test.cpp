#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "nodes/solids/synthesis/whole/measures.h"
#include "runtime/random.h"
#include "tests/nodes/solids/solid_optimize/exemplars.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using test::code_of;
using namespace test;

// Upright stripes, like grain.
Image stripes(int n, double period) {
  Image image(n, n, 1, 0.1);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const auto t = static_cast<float>(
          0.5 + 0.5 * std::sin(2 * std::numbers::pi * x / period + 0.3 * std::sin(0.2 * y)));
      image.at(x, y) = Vec3f(0.2f + 0.5f * t, 0.1f + 0.3f * t, 0.1f);
    }
  return image;
}

using Parameters = std::map<std::string, std::string>;

test::NodeRun solid(const Image& exemplar, Parameters p = {}, int threads = 0) {
  p.try_emplace("size", "32");
  p.try_emplace("iterations", "[6, 3]");
  return test::run_node("SolidOptimize", {{"exemplar", Value::of<Image>(exemplar)}}, p, {}, threads);
}

const openvdb::Vec3SGrid& colors(const test::NodeRun& r) {
  return *r.output<Volume>("volume").find<openvdb::Vec3SGrid>("Cd");
}

TEST(SolidOptimize, GivesAVoxelForEachPixelOfAnySize) {
  const auto r = solid(blobs(48, 40, 8, 1), {{"size", "[17, 24, 35]"}});
  const auto& v = r.output<Volume>("volume");
  EXPECT_EQ(v.resolution, Vec3i(17, 24, 35));
  EXPECT_EQ(colors(r).activeVoxelCount(), 17u * 24 * 35);
  EXPECT_DOUBLE_EQ(colors(r).voxelSize()[0], 0.1);
  for (auto it = colors(r).cbeginValueOn(); it; ++it)
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite((*it)[c]) && (*it)[c] >= 0);
}

TEST(SolidOptimize, HasTheExemplarsColors) {
  const Image e = blobs(64, 64, 9, 2);
  const auto r = solid(e);
  Vec3 mean = Vec3::Zero(), wanted = Vec3::Zero(), square = Vec3::Zero(), wanted_square = Vec3::Zero();
  for (auto it = colors(r).cbeginValueOn(); it; ++it) {
    const Vec3 c((*it)[0], (*it)[1], (*it)[2]);
    mean += c / (32.0 * 32 * 32);
    square += c.cwiseProduct(c) / (32.0 * 32 * 32);
  }
  for (const auto& p : e.pixels)
    wanted += p.cast<double>() / (64.0 * 64), wanted_square += p.cast<double>().cwiseAbs2() / (64.0 * 64);
  EXPECT_LT((mean - wanted).norm(), 0.02);
  EXPECT_LT((square - wanted_square).norm(), 0.03);
  EXPECT_LT(r.metrics.at("histogram_distance"), 0.05);
}

TEST(SolidOptimize, SectionsLookMoreLikeTheExemplarThanNoiseOfItsColors) {
  namespace so = solids;
  const Image e = blobs(64, 64, 7, 3);
  so::SolidOptions s;
  s.size = Vec3i::Constant(40);
  s.iterations = {8, 4};
  so::SolidExemplar exemplar;
  exemplar.width = exemplar.height = 64;
  exemplar.pixels = e.pixels;
  const so::SolidResult r = so::optimize_solid({exemplar}, s, Work());
  so::SolidExemplar working = exemplar;
  for (auto& p : working.pixels) p = r.axes.to(p);
  so::SolidField noise = r.field;
  for (std::size_t i = 0; i < noise.channel[0].size(); ++i) {
    const std::size_t pick = Random(5, 0, i).below(working.pixels.size());
    for (std::size_t c = 0; c < noise.channel.size(); ++c)
      noise.channel[c][i] = working.pixels[pick][static_cast<Eigen::Index>(c)];
  }
  std::vector<so::PlaneMeasures> measures(3);
  for (int a = 0; a < 3; ++a) measures[static_cast<std::size_t>(a)].axis = a;
  so::measure_planes({working}, s, noise, measures, Work());
  for (int a = 0; a < 3; ++a)
    EXPECT_LT(r.measures[static_cast<std::size_t>(a)].patches,
              0.5 * measures[static_cast<std::size_t>(a)].patches)
        << a;
}

TEST(SolidOptimize, FinestBandsAreTheExemplars) {
  const Image veined = test::run_node("Pattern", {}, {{"kind", "marble"}, {"width", "64"}, {"height", "64"}})
                           .output<Image>("image");
  for (const Image& picture : {blobs(64, 64, 6, 4), veined}) {
    const auto r = solid(picture, {{"size", "48"}});
    const auto& t = r.output<Table>("table");
    ASSERT_EQ(t.rows.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(t.number(k, "band high"), 1, 0.1) << k;
  }
}

TEST(SolidOptimize, NoPlaneIsCopiedNorStriped) {
  for (std::uint64_t seed : {5, 6}) {
    const auto m = solid(blobs(64, 64, 7, seed), {{"size", "40"}}).metrics;
    EXPECT_LT(m.at("copied_worst"), 0.4);
    EXPECT_LT(m.at("stripes_worst"), 4);
  }
}

TEST(SolidOptimize, LessIsCopiedWhereCopyingCountsAsFurther) {
  const Image e = blobs(64, 64, 7, 8);
  const auto free = solid(e, {{"size", "48"}, {"copying", "0"}}).metrics,
             kept = solid(e, {{"size", "48"}, {"copying", "1"}}).metrics;
  EXPECT_LT(kept.at("copied_worst"), 0.7 * free.at("copied_worst"));
  EXPECT_LT(kept.at("patch_distance"), 1.3 * free.at("patch_distance"));
}

TEST(SolidOptimize, IsPeriodic) {
  // Among the planes across an axis, the one at the wrap is not special.
  const auto r = solid(blobs(64, 64, 9, 7), {{"size", "48"}});
  const auto grid = colors(r).getConstAccessor();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> step(48, 0);
    for (int k = 0; k < 48; ++k)
      for (int u = 0; u < 48; ++u)
        for (int v = 0; v < 48; ++v) {
          openvdb::Coord a, b;
          a[axis] = k;
          b[axis] = (k + 1) % 48;
          a[(axis + 1) % 3] = b[(axis + 1) % 3] = u, a[(axis + 2) % 3] = b[(axis + 2) % 3] = v;
          step[static_cast<std::size_t>(k)] += (grid.getValue(a) - grid.getValue(b)).length();
        }
    double mean = 0;
    for (int k = 0; k < 47; ++k) mean += step[static_cast<std::size_t>(k)] / 47;
    double variance = 0;
    for (int k = 0; k < 47; ++k) variance += std::pow(step[static_cast<std::size_t>(k)] - mean, 2) / 46;
    EXPECT_LT(std::abs(step[47] - mean), 4 * std::sqrt(variance)) << axis;
  }
}

TEST(SolidOptimize, UprightGrainStandsUprightOnTwoPlanes) {
  const auto r = solid(stripes(64, 9));
  ASSERT_EQ(r.warnings.size(), 1u);  // three planes cannot share a direction
  EXPECT_GT(r.metrics.at("directedness"), 0.8);
  const auto grid = colors(r).getConstAccessor();
  double along[3] = {0, 0, 0};
  for (int i = 0; i < 32; ++i)
    for (int j = 0; j < 32; ++j)
      for (int k = 0; k < 32; ++k)
        for (int a = 0; a < 3; ++a) {
          openvdb::Coord at(i, j, k), next = at;
          next[a] = (next[a] + 1) % 32;
          along[a] += (grid.getValue(at) - grid.getValue(next)).lengthSqr();
        }
  EXPECT_LT(along[2], 0.3 * along[0]);
  EXPECT_LT(along[2], 0.3 * along[1]);
}

TEST(SolidOptimize, EachPlaneHasAnExemplarOfItsOwn) {
  // Blobs across z, upright stripes across x and y: no single exemplar shows both.
  const auto r = test::run_node(
      "SolidOptimize",
      {{"exemplar", Value::of<Image>(stripes(64, 9))}, {"exemplar_z", Value::of<Image>(blobs(64, 64, 9, 1))}},
      {{"size", "32"}, {"iterations", "[6, 3]"}, {"sources", "true"}});
  const auto& volume = r.output<Volume>("volume");
  const auto source = volume.find<openvdb::Vec3IGrid>("source");
  ASSERT_TRUE(source);
  bool seen[2] = {false, false};
  for (auto it = source->cbeginValueOn(); it; ++it) {
    const auto s = *it;
    ASSERT_TRUE(s[0] >= 0 && s[0] < 64 && s[1] >= 0 && s[1] < 64 && (s[2] == 0 || s[2] == 1));
    seen[s[2]] = true;
  }
  EXPECT_TRUE(seen[0] && seen[1]);
}

TEST(SolidOptimize, FeaturesComeFromTheSourcesPixel) {
  const Image e = blobs(48, 48, 8, 9);
  Image place(48, 48, 1, 0.1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x) place.at(x, y) = Vec3f(static_cast<float>(x), static_cast<float>(y), 7);
  const auto r = test::run_node("SolidOptimize",
                                {{"exemplar", Value::of<Image>(e)}, {"features", Value::of<Image>(place)}},
                                {{"size", "24"}, {"iterations", "4"}, {"sources", "true"}});
  const auto source = r.output<Volume>("volume").find<openvdb::Vec3IGrid>("source");
  const auto features = r.output<Volume>("volume").find<openvdb::Vec3SGrid>("features");
  ASSERT_TRUE(source && features);
  const auto at = features->getConstAccessor();
  for (auto it = source->cbeginValueOn(); it; ++it) {
    const auto f = at.getValue(it.getCoord());
    ASSERT_EQ(f[0], static_cast<float>((*it)[0]));
    ASSERT_EQ(f[1], static_cast<float>((*it)[1]));
    ASSERT_EQ(f[2], 7);
  }
}

TEST(SolidOptimize, NothingComesFromWhereTheMaskForbids) {
  const Image e = blobs(64, 48, 8, 10);
  Labels mask;
  mask.width = 64;
  mask.height = 48;
  mask.ids.assign(64 * 48, 1);
  mask.classes = {0};
  for (int y = 0; y < 48; ++y)
    for (int x = 40; x < 64; ++x) mask.ids[static_cast<std::size_t>(y) * 64 + x] = 0;
  const auto r =
      test::run_node("SolidOptimize", {{"exemplar", Value::of<Image>(e)}, {"masks", Value::of<Labels>(mask)}},
                     {{"size", "24"}, {"iterations", "4"}, {"sources", "true"}});
  const auto source = r.output<Volume>("volume").find<openvdb::Vec3IGrid>("source");
  for (auto it = source->cbeginValueOn(); it; ++it) ASSERT_LT((*it)[0], 40);
}

TEST(SolidOptimize, SameContentOnAnyNumberOfThreads) {
  const Image e = blobs(48, 48, 7, 11);
  const auto one = solid(e, {{"size", "[25, 24, 33]"}}, 1), three = solid(e, {{"size", "[25, 24, 33]"}}, 3);
  auto a = colors(one).cbeginValueOn();
  const auto b = colors(three).getConstAccessor();
  for (; a; ++a) ASSERT_EQ(*a, b.getValue(a.getCoord()));
  const auto other = solid(e, {{"size", "[25, 24, 33]"}, {"seed", "2"}});
  std::size_t different = 0;
  const auto c = colors(other).getConstAccessor();
  for (auto i = colors(one).cbeginValueOn(); i; ++i) different += *i != c.getValue(i.getCoord());
  EXPECT_GT(different, 10000u);
}

TEST(SolidOptimize, NeedsNoMoreMemoryThanItForecasts) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers keep memory of their own for every byte";
#endif
  namespace so = solids;
  const Image e = blobs(64, 64, 8, 1);
  so::SolidExemplar exemplar;
  exemplar.width = exemplar.height = 64;
  exemplar.pixels = e.pixels;
  so::SolidOptions s;
  s.size = Vec3i::Constant(96);
  s.iterations = {1};
  so::SolidResult r;
  const double used = peak_of([&] { r = so::optimize_solid({exemplar}, s, Work()); }),
               forecast = so::memory_forecast({exemplar}, s);
  if (used < 0) GTEST_SKIP() << "peak memory is not available here";
  EXPECT_LT(used, 1.1 * forecast + 4e6);  // threads and tables that do not grow with the solid
  EXPECT_GT(used, 0.5 * forecast);
}

TEST(SolidOptimize, GrayAndLinearAreTakenToo) {
  Image gray = blobs(48, 48, 7, 12);
  for (auto& p : gray.pixels) p = Vec3f::Constant(p.mean());
  const auto r = solid(gray, {{"size", "24"}, {"color", "linear"}});
  for (auto it = colors(r).cbeginValueOn(); it; ++it) ASSERT_NEAR((*it)[0], (*it)[2], 1e-3);
}

// The 2011 paper works in the red, green and blue of its pictures: no rotation, no other colors.
TEST(SolidOptimize, RgbAxesAreTheStoredChannels) {
  namespace so = solids;
  const Image image = blobs(48, 48, 7, 12);
  const so::ColorAxes axes = so::color_axes({&image.pixels}, so::SolidColor::Rgb);
  EXPECT_EQ(axes.channels, 3);
  EXPECT_EQ((axes.axes.cwiseAbs().rowwise().maxCoeff() - Vec3::Ones()).norm(), 0);
  EXPECT_EQ(axes.axes.cwiseAbs().sum(), 3);
  Vec3 mean = Vec3::Zero(), square = Vec3::Zero();
  for (const Vec3f& p : image.pixels) {
    const Vec3f w = axes.to(p);
    EXPECT_LT((axes.from(w) - p).norm(), 1e-5f);
    // Each working channel is one encoded channel, moved and scaled.
    const Vec3f stored = axes.axes.cast<float>().transpose() * linear_to_srgb(p);
    EXPECT_LT((w / axes.scale + axes.axes.cast<float>().transpose() * axes.mean - stored).norm(), 1e-5f);
    mean += w.cast<double>();
    square += w.cast<double>().cwiseAbs2();
  }
  const double n = static_cast<double>(image.pixels.size());
  const Vec3 variance = square / n - (mean / n).cwiseAbs2();
  EXPECT_NEAR(variance.sum(), 1, 1e-4);
  EXPECT_GE(variance[0], variance[1]);
  EXPECT_GE(variance[1], variance[2]);
}

TEST(SolidOptimize, ThePapersRecipeGivesASolidOfTheExemplarsColors) {
  const auto r = solid(
      blobs(32, 32, 7, 13),
      {{"method", "reference"}, {"color", "rgb"}, {"size", "16"}, {"iterations", "[3, 2]"}, {"levels", "2"}});
  Vec3 mean = Vec3::Zero();
  for (auto it = colors(r).cbeginValueOn(); it; ++it) {
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite((*it)[c]));
    mean += Vec3((*it)[0], (*it)[1], (*it)[2]) / (16.0 * 16 * 16);
  }
  Vec3 wanted = Vec3::Zero();
  for (const auto& p : blobs(32, 32, 7, 13).pixels) wanted += p.cast<double>() / (32.0 * 32);
  EXPECT_LT((mean - wanted).norm(), 0.25);
}

TEST(SolidOptimize, SaysWhatIsWrong) {
  EXPECT_EQ(code_of([] { solid(Image(64, 64, 1, 1, Vec3f(0.3f, 0.2f, 0.1f))); }), "one-color");
  EXPECT_EQ(code_of([] { solid(blobs(64, 7, 5, 1)); }), "exemplar-too-small");
  EXPECT_EQ(code_of([] { solid(blobs(64, 64, 8, 1), {{"size", "2000"}}); }), "too-large");
  EXPECT_EQ(code_of([] { solid(blobs(64, 64, 8, 1), {{"size", "[32, 32]"}}); }), "bad-value");
  EXPECT_EQ(code_of([] { solid(blobs(64, 64, 8, 1), {{"size", "0"}}); }), "bad-value");
  EXPECT_EQ(code_of([] { solid(blobs(64, 64, 8, 1), {{"planes", "[w]"}}); }), "bad-value");
  EXPECT_EQ(code_of([] { solid(blobs(64, 64, 8, 1), {{"levels", "6"}}); }), "exemplar-too-small");
  Image broken = blobs(64, 64, 8, 1);
  broken.at(5, 6)[1] = std::nanf("");
  EXPECT_EQ(code_of([&] { solid(broken); }), "bad-pixels");
  Labels none;
  none.width = none.height = 64;
  none.ids.assign(64 * 64, 0);
  EXPECT_EQ(code_of([&] {
              test::run_node(
                  "SolidOptimize",
                  {{"exemplar", Value::of<Image>(blobs(64, 64, 8, 1))}, {"masks", Value::of<Labels>(none)}},
                  {{"size", "32"}});
            }),
            "exemplar-too-small");
  none.width = 32;
  EXPECT_EQ(code_of([&] {
              test::run_node(
                  "SolidOptimize",
                  {{"exemplar", Value::of<Image>(blobs(64, 64, 8, 1))}, {"masks", Value::of<Labels>(none)}},
                  {{"size", "32"}});
            }),
            "size-mismatch");
}

}  // namespace
}  // namespace terrazzo
