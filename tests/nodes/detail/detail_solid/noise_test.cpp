#include "nodes/detail/detail_solid/noise.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/detail/residual/camera_noise.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/wave_field.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace detail_solid;
using test::run_node;

constexpr int kEdge = 320;

// White noise that is blurred with [1 2 1] both ways, of deviation 1: neighbors correlate by 2/3.
std::vector<float> blurred_noise(std::uint64_t seed) {
  const auto white = [&](int x, int y) {
    return Random(seed, static_cast<std::uint64_t>(y + 1), static_cast<std::uint64_t>(x + 1)).normal();
  };
  std::vector<float> out;
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      double sum = 0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) sum += (2 - std::abs(i)) * (2 - std::abs(j)) * white(x + i, y + j);
      out.push_back(static_cast<float>(sum / 6));  // the weights' squares sum to 36
    }
  return out;
}

float flat(int id) { return id == 0 ? 0.7f : id % 2 ? 0.3f : 0.45f; }

// Disks with noise of a deviation that may depend on the label.
template <class Deviation>
test::DrawnPicture noisy_disks(Deviation&& deviation) {
  const std::vector<float> noise = blurred_noise(5);
  return test::draw_disks(kEdge, 80, 30, [&](int x, int y, int id) {
    return Vec3f(Vec3f::Constant(flat(id) + deviation(id) * noise[pixel_at(x, y, kEdge)]));
  });
}

struct Moments {
  double deviation, beside;  // of lightness, and the correlation of neighbors along x
};

// About the flat colors.
Moments moments_of(const Image& image, const Labels& labels, float far = 0) {
  const auto depth = residual::outline_depth(labels.ids.data(), labels.width, labels.height, false);
  double square = 0, product = 0, count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x + 1 < image.width; ++x) {
      const int id = labels.ids[labels.index(x, y)];
      if (id != labels.ids[labels.index(x + 1, y)] || depth[labels.index(x, y)] < far) continue;
      const double a = linear_to_srgb(image.at(x, y)).mean() - flat(id),
                   b = linear_to_srgb(image.at(x + 1, y)).mean() - flat(id);
      square += a * a;
      product += a * b;
      ++count;
    }
  return {std::sqrt(square / count), product / square};
}

TEST(CameraNoise, IsTakenOutAndAddedAgain) {
  const auto drawn = noisy_disks([](int) { return 0.03f; });
  const Moments before = moments_of(drawn.image, drawn.labels);
  ASSERT_NEAR(before.deviation, 0.03, 0.001);
  Image clean = drawn.image;
  const Detail::Noise noise = split_noise(clean, drawn.labels, nullptr, 0, true);
  ASSERT_FALSE(noise.gray.empty());
  EXPECT_TRUE(noise.chroma.empty());
  // Within two pixels of an outline, some of the step between two flat colors is lost.
  EXPECT_LT(moments_of(clean, drawn.labels, 2).deviation, 0.3 * before.deviation);

  Image again = drawn.image;
  for (std::size_t i = 0; i < again.pixels.size(); ++i)
    again.pixels[i] = srgb_to_linear(Vec3f::Constant(flat(drawn.labels.ids[i])));
  residual::Camera camera;
  camera.noise = &noise;
  camera.noise_pixel = 0.1;
  residual::add_noise(again.pixels.data(), kEdge, kEdge, 0.1, false, camera, 0, Work());
  const Moments after = moments_of(again, drawn.labels);
  EXPECT_NEAR(after.deviation, before.deviation, 0.1 * before.deviation);
  EXPECT_NEAR(after.beside, before.beside, 0.08);
}

TEST(CameraNoise, FollowsLightness) {
  const auto drawn = noisy_disks([](int id) { return id == 0 ? 0.035f : 0.02f; });
  Image clean = drawn.image;
  const Detail::Noise noise = split_noise(clean, drawn.labels, nullptr, 0, true);
  ASSERT_FALSE(noise.gray.empty());
  EXPECT_NEAR(residual::deviation_at(noise.gray, 0.7f), 0.035f, 0.005f);
  EXPECT_NEAR(residual::deviation_at(noise.gray, 0.3f), 0.02f, 0.003f);
}

TEST(CameraNoise, IsTheSameForAnyNumberOfThreads) {
  const auto drawn = noisy_disks([](int) { return 0.03f; });
  std::vector<std::vector<char>> bytes;
  for (int threads : {1, 2, 7}) {
    const auto run =
        run_node("DetailSolid", {{"image", Value::of(drawn.image)}, {"labels", Value::of(drawn.labels)}},
                 {{"size", "16"}}, {}, threads);
    EXPECT_FALSE(run.outputs.at("detail").as<Detail>().noise.gray.empty());
    BufferWriter writer;
    const Value& detail = run.outputs.at("detail");
    detail.type().encode(detail.data(), writer);
    bytes.push_back(writer.buffer);
  }
  EXPECT_TRUE(bytes[1] == bytes[0]);
  EXPECT_TRUE(bytes[2] == bytes[0]);
}

// Whether the picture stays as it is.
bool keeps(const test::DrawnPicture& drawn) {
  Image image = drawn.image;
  return split_noise(image, drawn.labels, nullptr, 0, true).gray.empty() &&
         image.pixels == drawn.image.pixels;
}

TEST(CameraNoise, GrainOfOnePhaseStays) {
  EXPECT_TRUE(keeps(noisy_disks([](int id) { return id == 0 ? 0.04f : 0.01f; })));
}

TEST(CameraNoise, BlotchesStay) {
  const residual::WaveField field(std::array{6.0f}, std::array{1.0f}, Vec3(kEdge, kEdge, kEdge));
  EXPECT_TRUE(keeps(test::draw_disks(kEdge, 80, 30, [&](int x, int y, int id) {
    return Vec3f(
        Vec3f::Constant(flat(id) + 0.03f * field.at({static_cast<float>(x), static_cast<float>(y), 5})));
  })));
}

// Grain of the same lightness that is stronger in some disks than in others is the material's.
TEST(CameraNoise, GrainThatDiffersFromPlaceToPlaceStays) {
  const std::vector<float> noise = blurred_noise(6);
  const auto drawn = test::draw_disks(kEdge, 40, 17, [&](int x, int y, int id) {
    const float deviation = id == 0 ? 0 : 0.005f * static_cast<float>(1 + id % 8);
    return Vec3f(Vec3f::Constant(0.4f + deviation * noise[pixel_at(x, y, kEdge)]));
  });
  EXPECT_TRUE(keeps(drawn));
}

TEST(CameraNoise, ChromaIsMeasuredApart) {
  const std::vector<float> gray = blurred_noise(7), red = blurred_noise(8);
  const auto drawn = test::draw_disks(kEdge, 80, 30, [&](int x, int y, int id) {
    const std::size_t at = pixel_at(x, y, kEdge);
    return Vec3f(Vec3f::Constant(flat(id) + 0.02f * gray[at]) + 0.01f * red[at] * Vec3f(1, 0, -1));
  });
  Image clean = drawn.image;
  const Detail::Noise noise = split_noise(clean, drawn.labels, nullptr, 0, false);
  ASSERT_FALSE(noise.chroma.empty());
  Image again(kEdge, kEdge, 1, 0.1, srgb_to_linear(Vec3f::Constant(0.7f)));
  residual::Camera camera;
  camera.noise = &noise;
  camera.noise_pixel = 0.1;
  residual::add_noise(again.pixels.data(), kEdge, kEdge, 0.1, false, camera, 0, Work());
  double mean = 0, chroma = 0;
  for (const Vec3f& v : again.pixels) {
    const Vec3f offset = linear_to_srgb(v).array() - 0.7f;
    mean += offset.mean() * offset.mean() / again.pixels.size();
    chroma += (offset.array() - offset.mean()).matrix().squaredNorm() / again.pixels.size();
  }
  EXPECT_NEAR(std::sqrt(mean), 0.02, 0.003);
  // The deviation of two axes is measured together; only one has noise here, of 0.01·√2.
  EXPECT_GT(std::sqrt(chroma), 0.005);
  EXPECT_LT(std::sqrt(chroma), 0.02);
}

TEST(CameraNoise, TilesAndDiffersBetweenPictures) {
  Detail::Noise noise;
  noise.gray.assign(4, 0.02f);
  constexpr int kSide = 2 * Detail::Noise::kReach + 1;
  noise.gray_kernel.assign(pixels_in(kSide, kSide), 1.0f / kSide);  // very broad
  residual::Camera camera;
  camera.noise = &noise;
  const auto picture = [&](bool wrap, std::uint64_t number) {
    Image out(70, 50, 1, 1, Vec3f::Constant(0.2f));
    residual::add_noise(out.pixels.data(), 70, 50, 1, wrap, camera, number, Work());
    return out;
  };
  // Neighbors across the edge differ as little as others.
  const auto step = [](const Image& p, int a, int b) {
    double sum = 0;
    for (int y = 0; y < p.height; ++y) sum += std::abs(p.at(a, y).x() - p.at(b, y).x());
    return sum;
  };
  const Image tile = picture(true, 0), open = picture(false, 0);
  EXPECT_LT(step(tile, 69, 0), 2.5 * step(tile, 34, 35));
  EXPECT_GT(step(open, 69, 0), 2.5 * step(open, 34, 35));
  EXPECT_TRUE(picture(true, 0).pixels == tile.pixels);
  EXPECT_FALSE(picture(true, 1).pixels == tile.pixels);
}

// Pixels three times as large have the noise of means over nine.
TEST(CameraNoise, LargerPixelsHaveThatOfMeans) {
  constexpr int kSide = 2 * Detail::Noise::kReach + 1;
  Detail::Noise noise;
  noise.gray.assign(4, 0.01f);
  noise.gray_kernel.assign(pixels_in(kSide, kSide), 0.0f);
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i)
      noise.gray_kernel[pixel_at(Detail::Noise::kReach + i, Detail::Noise::kReach + j, kSide)] =
          static_cast<float>((2 - std::abs(i)) * (2 - std::abs(j))) / 6;
  residual::Camera camera;
  camera.noise = &noise;
  const auto offsets = [&](int size, double pixel) {
    Image out(size, size, 1, pixel, srgb_to_linear(Vec3f::Constant(0.5f)));
    residual::add_noise(out.pixels.data(), size, size, pixel, false, camera, 0, Work());
    std::vector<float> v;
    for (const Vec3f& c : out.pixels) v.push_back(linear_to_srgb(c).mean() - 0.5f);
    return v;
  };
  const auto deviation = [](const std::vector<float>& v) {
    double square = 0;
    for (const float x : v) square += static_cast<double>(x) * x;
    return std::sqrt(square / static_cast<double>(v.size()));
  };
  const std::vector<float> fine = offsets(300, 1);
  std::vector<float> means;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      float sum = 0;
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) sum += fine[pixel_at(3 * x + i, 3 * y + j, 300)];
      means.push_back(sum / 9);
    }
  EXPECT_NEAR(deviation(fine), 0.01, 0.0003);
  EXPECT_NEAR(deviation(offsets(100, 3)), deviation(means), 0.0003);
}

// What the mask hides teaches nothing, and several sections are measured together.
TEST(CameraNoise, KnowsMasksAndSections) {
  const auto drawn = noisy_disks([](int) { return 0.03f; });
  Image two(kEdge, kEdge, 2, 0.1);
  Labels labels = drawn.labels, mask = drawn.labels;
  labels.sections = mask.sections = 2;
  labels.ids.insert(labels.ids.end(), drawn.labels.ids.begin(), drawn.labels.ids.end());
  mask.ids.assign(labels.ids.size(), 0);
  Random random(3);
  for (std::size_t i = 0; i < two.pixels.size(); ++i) {
    const bool second = i >= drawn.image.pixels.size();
    two.pixels[i] =
        second ? Vec3f(Vec3f::Constant(static_cast<float>(random.uniform()))) : drawn.image.pixels[i];
    mask.ids[i] = second;
  }
  const Detail::Noise noise = split_noise(two, labels, &mask, 0, true);
  ASSERT_FALSE(noise.gray.empty());
  EXPECT_NEAR(residual::deviation_at(noise.gray, 0.7f), 0.03f, 0.005f);
}

TEST(CameraNoise, SmallPicturesHaveNone) {
  for (const int size : {1, 15, 31}) {
    auto drawn = test::draw_disks(size, 16, 5, [](int x, int y, int) {
      return Vec3f(Vec3f::Constant(0.5f + 0.1f * static_cast<float>((x * 7 + y * 13) % 5)));
    });
    EXPECT_TRUE(keeps(drawn)) << size;
  }
}

// Noise and blotches: what is broad stays with the material.
TEST(CameraNoise, BlotchesBehindItStay) {
  const residual::WaveField field(std::array{6.0f}, std::array{1.0f}, Vec3(kEdge, kEdge, kEdge));
  const auto at = [&](int x, int y) {
    return 0.015f * field.at({static_cast<float>(x), static_cast<float>(y), 5});
  };
  const std::vector<float> noise = blurred_noise(5);
  const auto drawn = test::draw_disks(kEdge, 80, 30, [&](int x, int y, int id) {
    return Vec3f(Vec3f::Constant(flat(id) + at(x, y) + 0.02f * noise[pixel_at(x, y, kEdge)]));
  });
  Image clean = drawn.image;
  ASSERT_FALSE(split_noise(clean, drawn.labels, nullptr, 0, true).gray.empty());
  double product = 0, square = 0;
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      const double v =
          linear_to_srgb(clean.at(x, y)).mean() - flat(drawn.labels.ids[drawn.labels.index(x, y)]);
      product += v * at(x, y);
      square += at(x, y) * at(x, y);
    }
  EXPECT_GT(product / square, 0.6);
}

TEST(CameraNoise, IsStoredWhole) {
  Detail d;
  d.size = 1;
  d.phases.resize(1);
  d.phases[0].tile.assign(1, Vec3f::Zero());
  d.noise.gray.assign(3, 0.02f);
  constexpr int kSide = 2 * Detail::Noise::kReach + 1;
  d.noise.gray_kernel.assign(pixels_in(kSide, kSide), 1.0f / kSide);
  const auto again = [](const Detail& detail) {
    BufferWriter writer;
    value_type<Detail>().encode(&detail, writer);
    Reader reader(writer.buffer.data(), writer.buffer.size());
    return *std::static_pointer_cast<const Detail>(value_type<Detail>().decode(reader));
  };
  EXPECT_EQ(again(d).noise.gray, d.noise.gray);
  EXPECT_EQ(again(d).noise.gray_kernel, d.noise.gray_kernel);
  d.noise.gray[1] = std::nanf("");
  EXPECT_THROW(again(d), Error);
  d.noise.gray[1] = 0;
  d.noise.gray_kernel.pop_back();
  EXPECT_THROW(again(d), Error);
}

}  // namespace
}  // namespace terrazzo
