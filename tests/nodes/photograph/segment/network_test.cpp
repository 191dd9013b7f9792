// The network and the particles made from what it says.
#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "nodes/photograph/instance_score/instance_score.h"
#include "nodes/photograph/segment/color/split.h"
#include "nodes/photograph/segment/network/basins.h"
#include "nodes/photograph/segment/network/instances.h"
#include "nodes/photograph/segment/network/judge.h"
#include "nodes/photograph/segment/network/model_pool.h"
#include "nodes/photograph/segment/network/network_particles.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

// What a perfect network says of these labels.
NetworkMaps ideal_maps(const std::vector<std::int32_t>& labels, int width, int height) {
  NetworkMaps m;
  m.width = width;
  m.height = height;
  const auto depth2 = squared_distance(labels, width, height, false, {});
  std::vector<float> deepest(labels.size() + 1, 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    deepest[labels[i]] = std::max(deepest[labels[i]], std::sqrt(depth2[i]));
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const float depth = std::sqrt(depth2[i]);
    m.inside.push_back(labels[i] > 0);
    m.border.push_back(labels[i] > 0 && depth < 1.5f);
    m.distance.push_back(labels[i] > 0 ? depth / deepest[labels[i]] : 0);
    m.not_material.push_back(0);
  }
  return m;
}

std::vector<std::int32_t> discs(int width, int height, const std::vector<std::array<double, 3>>& all) {
  std::vector<std::int32_t> labels(static_cast<std::size_t>(width) * height, 0);
  for (std::size_t k = 0; k < all.size(); ++k)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (std::hypot(x - all[k][0], y - all[k][1]) < all[k][2])
          labels[static_cast<std::size_t>(y) * width + x] = static_cast<std::int32_t>(k + 1);
  return labels;
}

Labels as_labels(std::vector<std::int32_t> ids, int width, int height) {
  Labels out;
  out.width = width;
  out.height = height;
  out.classes.assign(*std::max_element(ids.begin(), ids.end()), 0);
  out.ids = std::move(ids);
  return out;
}

TEST(Network, AMirroredPictureHasMirroredMaps) {
  Image image(64, 64, 1, 1), mirrored = image;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const float v = std::hypot(x - 20.0f, y - 30.0f) < 12 ? 0.7f : 0.2f + 0.002f * static_cast<float>(x);
      image.at(x, y) = mirrored.at(63 - x, y) = Vec3f(v, 0.9f * v, 0.8f * v);
    }
  const Network network(built_in_model());
  const std::array<double, 1> whole{1.0};
  const NetworkMaps a = network(encoded_section(image, 0), whole, {}).front(),
                    b = network(encoded_section(mirrored, 0), whole, {}).front();
  EXPECT_GT(*std::max_element(a.inside.begin(), a.inside.end()), 0.5f);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * 64 + x,
                        j = static_cast<std::size_t>(y) * 64 + 63 - x;
      ASSERT_EQ(a.inside[i], b.inside[j]) << x << ' ' << y;
      ASSERT_EQ(a.border[i], b.border[j]) << x << ' ' << y;
    }
}

TEST(NetworkBasins, IdealMapsGiveTheLabelsBack) {
  const int w = 96, h = 80;
  const auto labels =
      discs(w, h, {{20, 20, 12}, {43, 22, 12}, {70, 30, 9}, {30, 55, 15}, {75, 60, 14}, {55, 64, 8}});
  const Labels found = as_labels(find_basins(ideal_maps(labels, w, h), {}), w, h);
  EXPECT_EQ(found.count(), 6);
  // Where two touch, the pass between them may go to either.
  EXPECT_EQ(instance_score::compare_instances(found, as_labels(labels, w, h)).average_precision(0.9), 1);
}

// Two summits without a border between them are one particle; with a border they are two.
TEST(NetworkBasins, AFaintBorderJoins) {
  const int w = 64, h = 40;
  const auto two = discs(w, h, {{20, 20, 13}, {44, 20, 13}});
  for (const float border : {0.1f, 0.9f}) {
    NetworkMaps m = ideal_maps(two, w, h);
    for (std::size_t i = 0; i < two.size(); ++i) {
      const bool meeting = two[i] > 0 && std::abs(static_cast<int>(i % w) - 32) < 3;
      if (meeting) m.border[i] = border;
    }
    const auto found = find_basins(m, {});
    EXPECT_EQ(*std::max_element(found.begin(), found.end()), border < 0.3f ? 1 : 2) << border;
  }
}

TEST(NetworkBasins, NothingIsFoundOutsideMaterial) {
  const int w = 40, h = 40;
  NetworkMaps m = ideal_maps(discs(w, h, {{20, 20, 10}}), w, h);
  m.not_material.assign(m.inside.size(), 1);
  const auto found = find_basins(m, {});
  EXPECT_EQ(std::count(found.begin(), found.end(), 0), w * h);
}

// Faint maps have no basins, but their levels still show every particle.
TEST(NetworkCandidates, FaintParticlesAreAmongThem) {
  const int w = 96, h = 80;
  const auto labels = discs(w, h, {{20, 20, 12}, {46, 22, 12}, {70, 50, 9}, {90, 20, 14}});
  const Labels truth = as_labels(labels, w, h);
  for (const float faint : {1.0f, 0.25f}) {
    NetworkMaps m = ideal_maps(labels, w, h);
    for (float& v : m.inside) v *= faint;
    const ScaleView view(m, 1, {});
    std::vector<double> best(truth.count(), 0);
    int basins = 0;
    for (const Candidate& c : view.candidates(25, {})) {
      const Cutout region = view.cut_out(c);
      basins += c.basin > 0;
      std::vector<std::int32_t> alone(labels.size(), 0);
      for (const auto i : region.pixels(w)) alone[i] = 1;
      for (std::int32_t k = 1; k <= truth.count(); ++k) {
        double both = 0, either = 0;
        for (std::size_t i = 0; i < labels.size(); ++i)
          both += alone[i] && labels[i] == k, either += alone[i] || labels[i] == k;
        best[k - 1] = std::max(best[k - 1], both / either);
      }
    }
    for (const double b : best) EXPECT_GT(b, 0.85) << faint;
    EXPECT_EQ(basins, faint == 1 ? 4 : 0);
  }
}

TEST(NetworkCandidates, EvidenceOfADiscIsKnown) {
  const int w = 80, h = 64;
  const auto labels = discs(w, h, {{40, 32, 15}});
  const ScaleView view(ideal_maps(labels, w, h), 0.7, {});
  const Cutout disc = cut_out_label(labels, w, h, 1, {25, 17, 31, 31});
  const Evidence e = evidence_of(disc, view, view.near_border());
  EXPECT_NEAR(e[0], std::log(3.1416 * 15 * 15), 0.02);
  EXPECT_NEAR(e[1], std::log(0.7), 1e-5);
  EXPECT_NEAR(e[2], std::log(1.03 / 0.03), 0.01);  // inside there, nothing around
  EXPECT_GT(e[3], 3);                              // a border along the outline, none within
  EXPECT_EQ(e[3], e[4]);                           // at the only scale
  EXPECT_EQ(e[5], 1);
  EXPECT_EQ(e[6], 0);
  EXPECT_LT(e[7], 0.06);           // distance as it should be
  EXPECT_NEAR(e[8], 1, 0.15);      // round
  EXPECT_NEAR(e[9], 1, 0.02);      // convex
  EXPECT_NEAR(e[10], 1, 0.02);     // as long as wide
  EXPECT_NEAR(e[11], 0.56, 0.03);  // radius / root of the area
  EXPECT_EQ(e[12], 0);
  EXPECT_EQ(e[13], 0);
}

// Regions at the edge and as large as the section have evidence too.
TEST(NetworkCandidates, EvidenceIsFinite) {
  const int w = 40, h = 30;
  std::vector<std::vector<std::int32_t>> all(4, std::vector<std::int32_t>(w * h, 0));
  std::fill(all[0].begin(), all[0].end(), 1);
  all[1][0] = 1;
  for (int x = 0; x < w; ++x) all[2][x] = 1;
  all[3][15 * w + 20] = 1;
  for (const auto& labels : all)
    for (const auto& maps :
         {ideal_maps(labels, w, h), ideal_maps(std::vector<std::int32_t>(w * h, 0), w, h)}) {
      const ScaleView view(maps, 1, {});
      for (const float v :
           evidence_of(cut_out_label(labels, w, h, 1, {0, 0, w, h}), view, view.near_border()))
        EXPECT_TRUE(std::isfinite(v));
    }
}

TEST(Judge, KnowsAParticleWhenItSeesOne) {
  const int w = 80, h = 64;
  const auto labels = discs(w, h, {{40, 32, 15}}), shifted = discs(w, h, {{52, 32, 15}});
  const ScaleView view(ideal_maps(labels, w, h), 1, {});
  std::vector<Evidence> evidence;
  for (const auto* l : {&labels, &shifted})
    evidence.push_back(evidence_of(cut_out_label(*l, w, h, 1, {0, 0, w, h}), view, view.near_border()));
  const auto overlap = built_in_judge()(evidence);
  ASSERT_EQ(overlap.size(), 2u);
  EXPECT_GT(overlap[0], 0.8);
  EXPECT_LT(overlap[1], 0.5);
  EXPECT_TRUE(built_in_judge()({}).empty());
}

TEST(Judge, OtherFilesAreRefused) {
  for (const std::string& bytes : {std::string(), std::string("no model")})
    EXPECT_EQ(test::code_of([&] { Judge judge(bytes); }), "bad-model");
  const Judge network(built_in_model());  // a model, but not of evidence
  EXPECT_EQ(test::code_of([&] { network(std::vector<Evidence>(3)); }), "bad-model");
}

double as_it_is(double score) { return score; }

Instance rectangle(int x0, int x1, int y0, int y1, int width, double score) {
  Instance out;
  out.score = score;
  for (std::int32_t y = y0; y < y1; ++y)
    for (std::int32_t x = x0; x < x1; ++x) out.pixels.push_back(y * width + x);
  return out;
}

TEST(NetworkInstances, AMoundGivesWayToTheStonesInIt) {
  const int w = 40, h = 20;
  const Instance mound = rectangle(0, 30, 0, 20, w, 0.9), left = rectangle(2, 10, 2, 10, w, 0.8),
                 right = rectangle(15, 25, 5, 15, w, 0.8), far = rectangle(32, 38, 2, 8, w, 0.6);
  const Accepted stones = accept_instances({mound, left, far, right}, w, h, 1, 0.45, as_it_is, {});
  EXPECT_EQ(stones.from, (std::vector<std::size_t>{1, 3, 2}));  // together worth 0.7, the mound 0.45
  EXPECT_EQ(stones.labels[5 * w + 5], 1);
  EXPECT_EQ(stones.labels[10 * w + 20], 2);
  EXPECT_EQ(stones.labels[0], 0);
  EXPECT_EQ(std::count(stones.labels.begin(), stones.labels.end(), 1), 64);
  // One part is worth less than the whole.
  const Accepted whole = accept_instances({mound, left, far}, w, h, 1, 0.45, as_it_is, {});
  EXPECT_EQ(whole.from, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(std::count(whole.labels.begin(), whole.labels.end(), 1), 600);
}

TEST(NetworkInstances, SpecksDoNotReplaceThePoreAroundThem) {
  const int w = 40, h = 20;
  Instance pore = rectangle(0, 30, 0, 20, w, 0.9);
  const Instance left = rectangle(2, 10, 2, 10, w, 0.8), right = rectangle(15, 25, 5, 15, w, 0.8);
  pore.explained = 0.3;  // they cover 164 of 600 pixels
  EXPECT_EQ(accept_instances({pore, left, right}, w, h, 1, 0.45, as_it_is, {}).from,
            (std::vector<std::size_t>{0}));
  pore.explained = 0.25;
  EXPECT_EQ(accept_instances({pore, left, right}, w, h, 1, 0.45, as_it_is, {}).from,
            (std::vector<std::size_t>{1, 2}));
}

TEST(NetworkInstances, ManyShapesOverlapNowhereAndKeepTheirOrder) {
  const int w = 64, h = 48;
  for (int seed = 1; seed <= 20; ++seed) {
    Random r(seed, 7, 0);
    std::vector<Instance> all;
    for (int k = 0; k < 60; ++k) {
      const int x = static_cast<int>(r.below(50)), y = static_cast<int>(r.below(36));
      all.push_back(rectangle(x, x + 2 + static_cast<int>(r.below(12)), y,
                              y + 2 + static_cast<int>(r.below(10)), w, r.uniform(0.3, 1)));
    }
    const Accepted a = accept_instances(all, w, h, 4, 0.5, as_it_is, {});
    ASSERT_EQ(a.scores.size(), a.from.size());
    EXPECT_TRUE(std::is_sorted(a.scores.rbegin(), a.scores.rend()));
    for (std::size_t k = 0; k < a.from.size(); ++k) {
      const auto& pixels = all[a.from[k]].pixels;
      EXPECT_EQ(a.scores[k], all[a.from[k]].score);
      EXPECT_GE(a.scores[k], 0.5);
      std::size_t own = 0;
      for (std::size_t i = 0; i < a.labels.size(); ++i)
        if (a.labels[i] == static_cast<std::int32_t>(k + 1)) {
          ++own;
          EXPECT_TRUE(std::binary_search(pixels.begin(), pixels.end(), static_cast<std::int32_t>(i)));
        }
      EXPECT_GE(own, 4u);
    }
  }
}

TEST(NetworkInstances, TheBetterOfTwoOverlappingOnesIsKept) {
  const int w = 30, h = 10;
  Instance good, poor, apart;
  for (std::int32_t y = 0; y < h; ++y)
    for (std::int32_t x = 0; x < w; ++x) {
      if (x < 10) good.pixels.push_back(y * w + x);
      if (x >= 3 && x < 14) poor.pixels.push_back(y * w + x);
      if (x >= 9 && x < 20) apart.pixels.push_back(y * w + x);
    }
  good.score = 0.9;
  poor.score = 0.8;
  apart.score = 0.7;
  const Accepted a = accept_instances({apart, poor, good}, w, h, 1, 0, as_it_is, {});
  ASSERT_EQ(a.scores, (std::vector<double>{0.9, 0.7}));
  EXPECT_EQ(a.labels[9], 1);   // the better one keeps the column that both want
  EXPECT_EQ(a.labels[10], 2);  // poor is covered by more than 0.4
  EXPECT_EQ(accept_instances({good}, w, h, 101, 0, as_it_is, {}).scores.size(), 0u);
  EXPECT_EQ(accept_instances({good}, w, h, 1, 0.95, as_it_is, {}).scores.size(), 0u);
}

Image noise_image(int width, int height) {
  Image image(width, height, 1, 1);
  Random r(7);
  for (auto& p : image.pixels)
    p = Vec3f(static_cast<float>(r.uniform()), static_cast<float>(r.uniform()),
              static_cast<float>(r.uniform()));
  return image;
}

TEST(Network, TheSameBitsOnAnyNumberOfThreads) {
  const Image image = noise_image(900, 800);  // four tiles, and one at the smaller scale
  const Network network(built_in_model());
  std::vector<NetworkMaps> all, half;
  for (const int threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    auto maps = network(encoded_section(image, 0), std::array{1.0, 0.5}, {});
    all.push_back(std::move(maps[0]));
    half.push_back(std::move(maps[1]));
  }
  for (const auto& m : half) EXPECT_EQ(m.inside, half[0].inside);
  for (const auto& m : all) {
    EXPECT_EQ(m.inside, all[0].inside);
    EXPECT_EQ(m.border, all[0].border);
    EXPECT_EQ(m.distance, all[0].distance);
    EXPECT_EQ(m.not_material, all[0].not_material);
  }
}

// Pictures in tiles have blobs of many shapes. Copies of the network for all of them would fill the memory.
TEST(Network, KeepsBuffersForFewShapes) {
  ModelPool pool(built_in_model(), "");
  const auto blob = [](int width) {
    const int shape[] = {1, 3, 640, width};
    return cv::Mat(4, shape, CV_32F, cv::Scalar(0.25 + width / 4096.0));
  };
  const auto equal = [](const cv::Mat& a, const cv::Mat& b) {
    return a.total() == b.total() && std::equal(a.ptr<float>(), a.ptr<float>() + a.total(), b.ptr<float>());
  };
  const cv::Mat first = pool.run(blob(512));
  std::size_t all = 640 * 512;
  for (int width = 544; width <= 736; width += 32) {
    pool.run(blob(width));
    all += static_cast<std::size_t>(640) * width;
    EXPECT_LE(pool.pixels_kept(), ModelPool::kMostPixels);
  }
  ASSERT_GT(all, ModelPool::kMostPixels);  // so some copies were dropped
  EXPECT_TRUE(equal(pool.run(blob(512)), first));
}

TEST(Network, AnySizeAndScale) {
  const Network network(built_in_model());
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 70}, {33, 64}, {65, 31}})
    for (const double scale : {0.5, 1.0, 1.4}) {
      const NetworkMaps m = network(encoded_section(noise_image(w, h), 0), std::array{scale}, {})[0];
      ASSERT_EQ(m.inside.size(), static_cast<std::size_t>(w) * h);
      for (const auto* map : {&m.inside, &m.border, &m.distance, &m.not_material})
        for (const float v : *map) ASSERT_TRUE(v >= 0 && v <= 1);
    }
}

TEST(Network, OtherFilesAreRefused) {
  std::string damaged = built_in_model();
  damaged.resize(damaged.size() / 3);
  for (const std::string& bytes : {std::string(), std::string("no model"), std::string(1000, '\0'), damaged})
    EXPECT_EQ(test::code_of([&] { Network network(bytes); }), "bad-model") << bytes.size();
}

// The network has not seen these pictures. The bounds are far below what it reaches
// (docs/results/photographs.md): they fail if the model, the order of its maps or the color encoding is
// wrong.
TEST(Network, FindsTheParticlesOfSyntheticPictures) {
  for (const auto scene : {synthetic_photo::Scene::Bank, synthetic_photo::Scene::Section}) {
    double precision = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      synthetic_photo::PhotoOptions o;
      o.scene = scene;
      o.seed = 900000 + seed;
      o.objects = false;
      o.fill = 0.4;
      const auto photo = synthetic_photo::take_photo(o, {});
      const auto found =
          test::run_node("Segment", {{"image", Value::of(photo.image)}}, {{"method", "network"}});
      precision += instance_score::compare_instances(found.output<Labels>("labels"), photo.labels)
                       .average_precision(0.5) /
                   4;
    }
    EXPECT_GT(precision, 0.4) << static_cast<int>(scene);
  }
}

}  // namespace
}  // namespace terrazzo
