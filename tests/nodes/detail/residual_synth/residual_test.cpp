#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "nodes/common/texture/color.h"
#include "nodes/data/labels.h"
#include "nodes/data/volume.h"
#include "nodes/detail/residual_synth/residual_image.h"
#include "nodes/detail/residual_synth/synthesize.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace residual_synth;

using test::code_of;

struct Picture {
  Image image;
  Labels labels;
};

// Discs of flat colors on a flat ground, with outlines blurred over `blur` pixels, plus grain: white noise
// and its average over 3 × 3 pixels, stronger in red.
Picture discs(int w, int h, double grain, double blur = 1.5) {
  Picture p;
  p.image = Image(w, h, 1, 0.05);
  p.labels.width = w;
  p.labels.height = h;
  p.labels.pixel_size = 0.05;
  p.labels.ids.assign(static_cast<std::size_t>(w) * h, 0);
  std::vector<float> white(p.labels.ids.size());
  for (std::size_t i = 0; i < white.size(); ++i) white[i] = static_cast<float>(Random(1, 0, i).normal());
  const int step = 32;
  const int columns = (w + step - 1) / step, rows = (h + step - 1) / step;
  p.labels.classes.assign(static_cast<std::size_t>(columns) * rows, 0);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const int id = y / step * columns + x / step;
      const double d = std::hypot(x % step - 15.5, y % step - 15.5) - 10;
      const float inside = static_cast<float>(std::clamp(0.5 - d / blur, 0.0, 1.0));
      Random r(7, 0, id);
      const auto bright = [&] { return static_cast<float>(r.uniform(0.3, 0.9)); };
      const Vec3f color(bright(), bright(), bright());
      float smooth = 0;
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u)
          smooth += white[static_cast<std::size_t>((y + v + h) % h) * w + (x + u + w) % w] / 3;
      const float g = static_cast<float>(grain) * (0.6f * white[p.image.index(x, y)] + 0.8f * smooth);
      p.image.at(x, y) = inside * color + (1 - inside) * Vec3f(0.5f, 0.5f, 0.4f) + g * Vec3f(1, 0.6f, 0.5f);
      if (d < 0) p.labels.ids[p.labels.index(x, y)] = id + 1;
    }
  return p;
}

test::NodeRun run(const Picture& p, std::map<std::string, std::string> parameters, int threads = 0) {
  return test::run_node("ResidualSynth", {{"image", Value::of(p.image)}, {"labels", Value::of(p.labels)}},
                        parameters, {}, threads);
}

std::vector<Vec3f> voxels_of(const test::NodeRun& r) {
  const auto& v = r.output<Volume>("volume");
  const auto grid = v.find<openvdb::Vec3SGrid>("residual");
  std::vector<Vec3f> out;
  for (int k = 0; k < v.resolution.z(); ++k)
    for (int j = 0; j < v.resolution.y(); ++j)
      for (int i = 0; i < v.resolution.x(); ++i) {
        const auto c = grid->tree().getValue({i, j, k});
        out.emplace_back(c[0], c[1], c[2]);
      }
  return out;
}

TEST(ResidualImage, OutlinesLeaveNoHalo) {
  const Picture flat = discs(128, 96, 0);
  const ResidualImage with = residual_image(flat.image, flat.labels, 0),
                      without = residual_image(flat.image, flat.labels, 2);
  const auto largest = [](const Image& i) {
    float m = 0;
    for (const auto& p : i.pixels) m = std::max(m, p.cwiseAbs().maxCoeff());
    return m;
  };
  EXPECT_GT(largest(with.image), 0.1f);
  EXPECT_LT(largest(without.image), 1e-5f);
  EXPECT_GT(without.filled, 0.05);
}

TEST(ResidualImage, KeepsGrainWithMeanZero) {
  const Picture p = discs(160, 128, 0.05);
  const ResidualImage r = residual_image(p.image, p.labels, 2);
  Vec3 mean = Vec3::Zero();
  double red = 0;
  for (const auto& v : r.image.pixels) {
    mean += v.cast<double>();
    red += double(v.x()) * v.x();
  }
  const double n = static_cast<double>(r.image.pixels.size());
  EXPECT_LT((mean / n).norm(), 1e-6);
  // 0.6² + 0.8² + 2·0.6·0.8/3: the grain's variance.
  EXPECT_NEAR(std::sqrt(red / n), 0.05 * std::sqrt(1.32), 0.0025);
}

TEST(ResidualImage, SpecksThatTheLabelsMissAreFilled) {
  Picture p = discs(128, 96, 0.02);
  for (int k = 0; k < 30; ++k) {
    const int x = 4 * (k % 8) * 4, y = 32 * (k / 8);  // on the ground between the discs
    for (int v = 0; v < 2; ++v)
      for (int u = 0; u < 2; ++u) p.image.at(x + u, std::min(y + v, 95)) = Vec3f(1, 0, 0);
  }
  const auto largest = [](const Image& i) {
    float m = 0;
    for (const auto& q : i.pixels) m = std::max(m, q.cwiseAbs().maxCoeff());
    return m;
  };
  const ResidualImage kept = residual_image(p.image, p.labels, 2, 0),
                      filled = residual_image(p.image, p.labels, 2, 6);
  EXPECT_GT(largest(kept.image), 0.35f);
  EXPECT_LT(largest(filled.image), 0.15f);
  EXPECT_GT(filled.specks, 0.002);
  EXPECT_EQ(kept.specks, 0);
}

TEST(ResidualImage, ShrinksItsBandWhereLittleIsLeft) {
  Picture p = discs(64, 64, 0.05);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) p.labels.ids[p.labels.index(x, y)] = (x / 3 + y / 3) % 2;
  p.labels.classes = {0};
  EXPECT_LT(residual_image(p.image, p.labels, 2).edge, 2);
}

TEST(ResidualSynth, SlicesLookLikeThePhotographToEveryBand) {
  const Picture p = discs(256, 224, 0.05);
  const auto r = run(p, {{"size", "64"}});
  for (const char* band : {"band_high", "band_1", "band_2", "band_3", "band_4", "band_low"})
    EXPECT_NEAR(r.metrics.at(band), 1, 0.05) << band;
  const ResidualImage residual = residual_image(as_displayed(p.image), p.labels, 2);
  const auto voxels = voxels_of(r);
  ASSERT_EQ(voxels.size(), 64u * 64 * 64);
  Vec3 mean = Vec3::Zero();
  for (const auto& v : voxels) mean += v.cast<double>() / double(voxels.size());
  EXPECT_LT(mean.norm(), 1e-6);
  for (int c = 0; c < 3; ++c) {  // histograms
    std::vector<float> a, b;
    for (const auto& v : residual.image.pixels) a.push_back(v[c]);
    for (const auto& v : voxels) b.push_back(v[c]);
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    double distance = 0;
    for (int q = 0; q < 1000; ++q)
      distance += std::abs(a[q * a.size() / 1000] - b[q * b.size() / 1000]) / 1000;
    EXPECT_LT(distance, 0.05 * r.metrics.at("deviation")) << c;
  }
  EXPECT_DOUBLE_EQ(r.output<Volume>("volume").grids[0]->voxelSize()[0], 0.05);
}

TEST(ResidualSynth, SmallSolidsHaveThePhotographsBandsToo) {
  for (const char* size : {"32", "[40, 32, 48]"}) {
    const auto r = run(discs(256, 224, 0.05), {{"size", size}});
    for (const char* band : {"band_high", "band_1", "band_2", "band_3", "band_low"})
      EXPECT_NEAR(r.metrics.at(band), 1, 0.05) << size << ' ' << band;
  }
}

TEST(ResidualSynth, BandsOfTheVolumeGiveSlicesTheWrongOnes) {
  const Picture p = discs(256, 224, 0.05);
  const auto r = run(p, {{"size", "48"}, {"method", "radial"}});
  EXPECT_LT(r.metrics.at("band_high"), 0.9);  // a slice projects it down
  EXPECT_GT(r.metrics.at("band_low"), 1.1);
  EXPECT_EQ(voxels_of(r), voxels_of(run(p, {{"size", "48"}, {"method", "radial"}}, 3)));
}

// Stripes that rise to the left, and noise.
Image leaning(int n, bool stripes) {
  Image image(n, n, 1, 0.05);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const double noise = Random(5, 0, image.index(x, y)).normal();
      const double wave = std::cos(2 * M_PI * (x - y) / 8.0);
      image.at(x, y) = Vec3f::Constant(static_cast<float>(0.5 + (stripes ? 0.1 * wave : 0.07 * noise)));
    }
  return image;
}

TEST(ResidualSynth, EachAxisGetsItsOwnPicture) {
  const auto with = [&](const char* port) {
    const std::multimap<std::string, Value> inputs = {{"image", Value::of(leaning(96, false))},
                                                      {port, Value::of(leaning(96, true))}};
    return voxels_of(test::run_node("ResidualSynth", inputs, {{"size", "32"}}));
  };
  // Slices across y and across z both have columns along x; their rows run along z and y, upwards. In the
  // picture, a step right and one down stay on a stripe.
  const auto correlation = [](const std::vector<Vec3f>& v, const Vec3i& step) {
    double sum = 0, square = 0;
    for (int k = 0; k < 32; ++k)
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) {
          const auto at = [&](int a, int b, int c) {
            return double(v[(((c + 32) % 32) * 32 + (b + 32) % 32) * 32 + (a + 32) % 32].x());
          };
          sum += at(i, j, k) * at(i + step.x(), j + step.y(), k + step.z());
          square += at(i, j, k) * at(i, j, k);
        }
    return sum / square;
  };
  const auto y = with("image_y"), z = with("image_z");
  EXPECT_GT(correlation(y, {2, 0, -2}), correlation(y, {2, 0, 2}) + 0.3);
  EXPECT_GT(correlation(z, {2, -2, 0}), correlation(z, {2, 2, 0}) + 0.3);
}

TEST(ResidualSynth, MeansAndResidualMakeThePhotographAgain) {
  const Picture p = discs(64, 48, 0.02);
  const auto r = run(p, {{"size", "16"}, {"edge", "0"}, {"specks", "0"}, {"preview", "true"}});
  const auto &means = r.output<Image>("means"), &about = r.output<Image>("residual");
  // In encoded values, all pixels differ from means + residual only by the binder's mean color.
  const auto offset = [&](std::size_t i) {
    return Vec3f(linear_to_srgb(p.image.pixels[i]) - linear_to_srgb(means.pixels[i]) -
                 linear_to_srgb(about.pixels[i]));
  };
  for (std::size_t i = 0; i < means.pixels.size(); ++i)
    ASSERT_LT((offset(i) - offset(0)).cwiseAbs().maxCoeff(), 2e-3f) << i;
  EXPECT_TRUE(r.output<Volume>("volume").find<openvdb::Vec3SGrid>("Cd"));
}

// Without labels nothing tells stones from binder, so none are removed unless `specks` says so.
TEST(ResidualSynth, SpecksAreRemovedByDefaultOnlyWithLabels) {
  const Picture p = discs(64, 48, 0.02);
  Labels missed = p.labels;  // one disc is unlabeled
  for (auto& id : missed.ids)
    if (id == missed.count()) id = 0;
  missed.classes.pop_back();
  const auto specks = [&](std::multimap<std::string, Value> inputs,
                          std::map<std::string, std::string> parameters) {
    parameters["size"] = "16";
    return test::run_node("ResidualSynth", std::move(inputs), parameters).metrics.at("specks");
  };
  const auto image = Value::of(p.image);
  EXPECT_EQ(specks({{"image", image}}, {}), 0);
  EXPECT_GT(specks({{"image", image}}, {{"specks", "6"}}), 0);
  EXPECT_GT(specks({{"image", image}, {"labels", Value::of(missed)}}, {}), 0.005);
  EXPECT_EQ(specks({{"image", image}, {"labels", Value::of(missed)}}, {{"specks", "0"}}), 0);
}

TEST(ResidualSynth, HasNoSeams) {
  const Picture p = discs(128, 128, 0.05);
  const auto r = run(p, {{"size", "[48, 40, 36]"}});
  const auto voxels = voxels_of(r);
  const Vec3i n(48, 40, 36);
  const auto at = [&](Vec3i q) {
    return voxels[(static_cast<std::size_t>(q.z()) * n.y() + q.y()) * n.x() + q.x()];
  };
  // Among the steps from plane to plane, the one across the wrap is not special.
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> step(static_cast<std::size_t>(n[axis]), 0);
    for (int k = 0; k < n.z(); ++k)
      for (int j = 0; j < n.y(); ++j)
        for (int i = 0; i < n.x(); ++i) {
          Vec3i next(i, j, k);
          next[axis] = (next[axis] + 1) % n[axis];
          step[static_cast<std::size_t>(Vec3i(i, j, k)[axis])] += (at({i, j, k}) - at(next)).squaredNorm();
        }
    double mean = 0, variance = 0;
    for (const double s : step) mean += s / n[axis];
    for (const double s : step) variance += (s - mean) * (s - mean) / (n[axis] - 1);
    EXPECT_LT(std::abs(step.back() - mean), 3 * std::sqrt(variance)) << axis;
    EXPECT_LT(std::sqrt(variance), 0.3 * mean) << axis;
  }
}

TEST(ResidualSynth, EqualForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const Picture p = discs(96, 80, 0.05);
  const auto one = voxels_of(run(p, {{"size", "32"}}, 1)), three = voxels_of(run(p, {{"size", "32"}}, 3));
  EXPECT_EQ(one, three);
  EXPECT_NE(one, voxels_of(run(p, {{"size", "32"}, {"seed", "2"}})));
}

TEST(ResidualSynth, OddAndSmallPicturesAndSizesWork) {
  for (const auto& [w, h, size] :
       {std::tuple{47, 61, "[31, 17, 23]"}, {16, 16, "40"}, {37, 300, "[16, 64, 20]"}}) {
    const auto r = run(discs(w, h, 0.05), {{"size", size}});
    for (const auto& v : voxels_of(r)) ASSERT_TRUE(v.allFinite());
    EXPECT_NEAR(r.metrics.at("band_high"), 1, 0.12) << size;
  }
}

TEST(ResidualSynth, GrayStaysGreyAndFlatStaysFlat) {
  Picture p = discs(64, 64, 0.05);
  for (auto& v : p.image.pixels) v = Vec3f::Constant(v.x());
  for (const auto& v : voxels_of(run(p, {{"size", "16"}})))
    ASSERT_LT(std::abs(v.x() - v.y()) + std::abs(v.x() - v.z()), 1e-6f);
  for (auto& v : p.image.pixels) v = Vec3f::Constant(0.5f);
  const auto flat = run(p, {{"size", "16"}});
  for (const auto& v : voxels_of(flat)) ASSERT_EQ(v, Vec3f::Zero());
  EXPECT_EQ(flat.warnings.size(), 1u);
}

TEST(ResidualSynth, BadInputIsSaid) {
  const Picture p = discs(64, 48, 0.05);
  Picture other = p, nan = p, tiny = discs(12, 64, 0.05);
  other.labels.width = 32;
  nan.image.pixels[5].x() = NAN;
  EXPECT_EQ(code_of([&] { run(other, {}); }), "size-mismatch");
  EXPECT_EQ(code_of([&] { run(nan, {}); }), "bad-pixels");
  EXPECT_EQ(code_of([&] { run(tiny, {{"size", "16"}}); }), "image-too-small");
  EXPECT_EQ(code_of([&] { run(p, {{"size", "[32, 32]"}}); }), "bad-value");
  EXPECT_EQ(code_of([&] {
              test::run_node("ResidualSynth",
                             {{"image", Value::of(p.image)}, {"image_z", Value::of(p.image)}},
                             {{"size", "16"}, {"method", "radial"}});
            }),
            "bad-value");
  Image coarser = p.image;
  coarser.pixel_size *= 2;
  EXPECT_EQ(code_of([&] {
              test::run_node("ResidualSynth",
                             {{"image", Value::of(p.image)}, {"image_z", Value::of(coarser)}},
                             {{"size", "16"}});
            }),
            "size-mismatch");
  EXPECT_EQ(code_of([&] {
              test::run_node("ResidualSynth",
                             {{"image", Value::of(p.image)}, {"labels_y", Value::of(p.labels)}},
                             {{"size", "16"}});
            }),
            "missing-input");
}

}  // namespace
}  // namespace terrazzo
