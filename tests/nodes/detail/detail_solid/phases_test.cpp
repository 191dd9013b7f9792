#include "nodes/detail/detail_solid/phases.h"

#include <gtest/gtest.h>

#include <tuple>

#include "graph/diagnostic.h"
#include "nodes/detail/detail_solid/broad.h"
#include "nodes/detail/detail_solid/contrast.h"
#include "nodes/detail/detail_solid/rim.h"
#include "nodes/detail/detail_solid/softness.h"
#include "nodes/detail/detail_solid/spectrum.h"
#include "nodes/detail/detail_solid/tiles.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

float noise(int x, int y, std::uint64_t stream) {
  return static_cast<float>(Random(7, stream, static_cast<std::uint64_t>(y) * 4096 + x).normal());
}

Vec3f two_colors(int x, int y, int id) {
  const Vec3f base = id == 0  ? Vec3f(0.5f, 0.5f, 0.5f)
                     : id % 2 ? Vec3f(0.8f, 0.3f, 0.2f)
                              : Vec3f(0.1f, 0.2f, 0.4f);
  return base.array() + 0.01f * noise(x, y, 1);
}

TEST(DetailPhases, OffsetsHaveMeanZeroAndColorsMakeGroups) {
  const auto drawn = test::draw_disks(240, 40, 14, two_colors);
  const Phases p = find_phases(drawn.image, drawn.labels, {});
  ASSERT_EQ(p.group_color.size(), p.pixels.size() - 1);
  ASSERT_GE(p.group_color.size(), 2u);
  // Disks of one color are in one group, disks of the other color in another.
  const auto phase_of = [&](int i, int j) {
    return p.phase[static_cast<std::size_t>(40 * j + 20) * 240 + 40 * i + 20];
  };
  EXPECT_NE(phase_of(0, 0), phase_of(1, 0));
  std::vector<Vec3> sum(p.pixels.size(), Vec3::Zero());
  std::vector<std::size_t> count(p.pixels.size(), 0);
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] >= 0) {
      sum[static_cast<std::size_t>(p.phase[i])] += p.offset[i].cast<double>();
      ++count[static_cast<std::size_t>(p.phase[i])];
    }
  EXPECT_EQ(count, p.pixels);
  for (std::size_t k = 0; k < sum.size(); ++k)
    EXPECT_LT((sum[k] / static_cast<double>(count[k])).norm(), 0.002);
}

TEST(DetailPhases, MaskedPixelsAreNotUsed) {
  auto drawn = test::draw_disks(240, 40, 10, two_colors);
  Labels mask = drawn.labels;
  std::fill(mask.ids.begin(), mask.ids.end(), 0);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 120; ++x) {
      const std::size_t i = drawn.labels.index(x, y);
      mask.ids[i] = 2;
      if (drawn.labels.ids[i] == 0) drawn.image.pixels[i] = Vec3f(0.6f, 0.5f, 0.4f);  // no outlier
    }
  PhaseOptions choice;
  choice.mask = &mask;
  const Phases p = find_phases(drawn.image, drawn.labels, choice);
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (mask.ids[i] != 0) ASSERT_EQ(p.phase[i], -1);
  EXPECT_EQ(p.pixels[0], static_cast<std::size_t>(std::count(p.phase.begin(), p.phase.end(), 0)));
  EXPECT_GT(p.pixels[0], 0u);
}

TEST(DetailPhases, MissedParticlesAreNotUsed) {
  auto drawn = test::draw_disks(240, 40, 10, two_colors);
  for (int y = 30; y < 50; ++y)
    for (int x = 30; x < 50; ++x) drawn.image.at(x, y) = Vec3f(0.9f, 0.9f, 0.9f);  // between four disks
  const Phases p = find_phases(drawn.image, drawn.labels, {});
  EXPECT_GT(p.outliers, 0);
  EXPECT_EQ(p.phase[40 * 240 + 40], -1);
  PhaseOptions all;
  all.specks = 0;
  EXPECT_EQ(find_phases(drawn.image, drawn.labels, all).phase[40 * 240 + 40], 0);
}

TEST(DetailPhases, PicturesMustHaveTheSizeOfTheLabels) {
  const auto drawn = test::draw_disks(80, 40, 10, two_colors);
  try {
    check_photograph(Image(81, 80, 1, 0.1), drawn.labels);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "size-mismatch");
  }
}

TEST(DetailRims, ABandAlongOutlinesIsFound) {
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    const double d = std::hypot(x % 80 + 0.5 - 40, y % 80 + 0.5 - 40) - 30;
    return Vec3f::Constant(id ? 0.3f : d < 4 ? 0.6f : 0.5f);
  });
  PhaseOptions choice;
  choice.edge = 0;
  choice.specks = 0;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  Detail d;
  d.phases.resize(p.pixels.size());
  split_rims(p, drawn.labels, d);
  ASSERT_EQ(d.phases[0].rims.size(), 1u);  // all disks have one size
  const auto& rim = d.phases[0].rims[0].offset;
  ASSERT_GE(rim.size(), 8u);
  const float far = rim.back().x();
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(rim[static_cast<std::size_t>(i)].x() - far, 0.1f, 0.02f) << i;
  EXPECT_NEAR(rim[6].x() - far, 0, 0.01f);
  for (std::size_t i = 0; i < p.offset.size(); ++i) {
    if (p.phase[i] == 0) {
      ASSERT_LT(p.offset[i].norm(), 0.18f);
    }
  }
}

TEST(DetailRims, LargeAndSmallProfilesHaveTheirOwn) {
  // A halo of 0.2 beside disks of radius 26, none beside disks of radius 9.
  constexpr int kSide = 320;
  Image image(kSide, kSide, 1, 0.1);
  Labels labels;
  labels.width = labels.height = kSide;
  labels.pixel_size = 0.1;
  labels.ids.assign(static_cast<std::size_t>(kSide) * kSide, 0);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int column = x / 80, row = y / 80;
      const double d = std::hypot(x % 80 + 0.5 - 40, y % 80 + 0.5 - 40), radius = (column + row) % 2 ? 26 : 9;
      const bool inside = d < radius;
      if (inside) labels.ids[static_cast<std::size_t>(y) * kSide + x] = 1 + column + 4 * row;
      const float encoded = inside ? 0.3f : radius > 20 && d < radius + 5 ? 0.6f : 0.4f;
      image.at(x, y) = srgb_to_linear(Vec3f::Constant(encoded));
    }
  labels.classes.assign(16, 0);
  PhaseOptions choice;
  choice.edge = 0;
  choice.specks = 0;
  Phases p = find_phases(image, labels, choice);
  Detail d;
  d.pixel_size = 0.1;
  d.phases.resize(p.pixels.size());
  split_rims(p, labels, d);
  const auto& rims = d.phases[0].rims;
  ASSERT_GE(rims.size(), 2u);
  EXPECT_NEAR(rims.front().size, 1.8f, 0.1f);  // mm
  EXPECT_NEAR(rims.back().size, 5.2f, 0.1f);
  const auto halo = [](const Detail::Rim& r) { return r.offset[1].x() - r.offset.back().x(); };
  EXPECT_NEAR(halo(rims.front()), 0, 0.02f);
  EXPECT_NEAR(halo(rims.back()), 0.2f, 0.02f);
  for (std::size_t i = 0; i < p.offset.size(); ++i)
    if (p.phase[i] == 0) {
      ASSERT_LT(p.offset[i].norm(), 0.2f) << i;
    }
}

TEST(DetailRims, SlopesAndContrastsAreMeasured) {
  // A slope of 0.1 per radius along x in every disk, and noise that is twice as strong in odd disks.
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    if (id == 0) return Vec3f(0.5f, 0.5f, 0.5f);
    const float slope = 0.1f * static_cast<float>(x % 80 + 0.5 - 40) / 30;
    return Vec3f(Vec3f::Constant(0.4f + slope + (id % 2 ? 0.04f : 0.02f) * noise(x, y, 5)));
  });
  PhaseOptions choice;
  choice.groups = 1;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  const auto slopes = split_slopes(p, drawn.labels);
  ASSERT_EQ(slopes.size(), 1u);
  // Along one axis, half of the square; relative to the color as Detail says.
  EXPECT_NEAR(slopes[0], 0.1 / 0.55 / std::sqrt(2.0), 0.015);
  Detail d;
  d.phases.resize(p.pixels.size());
  split_contrasts(p, drawn.image, drawn.labels, d);
  ASSERT_EQ(d.profile_contrast.size(), 16u);
  EXPECT_NEAR(d.profile_contrast[0].x() / d.profile_contrast[1].x(), 2, 0.1);
  EXPECT_NEAR(d.profile_contrast[2].x() / d.profile_contrast[3].x(), 2, 0.1);
}

TEST(DetailRims, SoftnessIsThatOfTheBlur) {
  for (const double sigma : {0.0, 1.0, 2.0}) {
    const auto drawn = test::draw_disks(320, 80, 30, [&](int x, int y, int) {
      const double d = 30 - std::hypot(x % 80 + 0.5 - 40, y % 80 + 0.5 - 40);
      const double share =
          sigma > 0 ? 0.5 * std::erfc(-d / (sigma * std::sqrt(2.0))) : std::clamp(d + 0.5, 0.0, 1.0);
      return Vec3f(Vec3f::Constant(static_cast<float>(0.6 - 0.4 * share)));
    });
    EXPECT_NEAR(outline_softness(drawn.image, drawn.labels), sigma, 0.35) << sigma;
  }
}

TEST(DetailBroad, FieldsHaveTheModelsCovariance) {
  BroadModel m;
  m.sigma = {4};
  m.variance = {Vec3(0.04, 0.01, 0)};
  const auto v = broad_field(m, 48, 3);
  double sum = 0, square = 0, at4 = 0, other = 0;
  const auto at = [&](int x, int y, int z) {
    return v[static_cast<std::size_t>((z % 48) * 48 + y % 48) * 48 + x % 48];
  };
  for (int z = 0; z < 48; ++z)
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x) {
        const Vec3f a = at(x, y, z);
        sum += a.x();
        square += a.x() * a.x();
        at4 += a.x() * at(x + 4, y, z).x();
        other += a.y() * a.y();
        EXPECT_EQ(a.z(), 0);
      }
  EXPECT_NEAR(sum / v.size(), 0, 1e-4);
  EXPECT_NEAR(square / v.size(), 0.04, 0.015);
  EXPECT_NEAR(at4 / square, std::exp(-16.0 / (4 * 16)), 0.08);
  EXPECT_NEAR(other / v.size(), 0.01, 0.004);
}

TEST(DetailSpectrum, SlicesGetThePhotographsCovariance) {
  // Grain whose neighbors correlate by 1/2; the tile starts from white noise of another deviation.
  const auto drawn = test::draw_disks(256, 128, 1, [](int x, int y, int) {
    const float v = noise(x, y, 9) + noise(x + 1, y, 9) + noise(x, y + 1, 9) + noise(x + 1, y + 1, 9);
    return Vec3f(Vec3f::Constant(0.5f + 0.01f * v));
  });
  const Phases p = find_phases(drawn.image, drawn.labels, {});
  constexpr int n = 48;
  std::vector<Vec3f> tile;
  for (std::uint64_t i = 0; i < n * n * n; ++i)
    tile.push_back(Vec3f::Constant(static_cast<float>(0.1 * Random(5, 5, i).normal())));
  match_spectrum(tile, n, p, 0);
  double square = 0, next = 0, diagonal = 0;
  const auto at = [&](int x, int y, int z) {
    return tile[static_cast<std::size_t>(z * n + y % n) * n + x % n].x();
  };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        square += at(x, y, z) * at(x, y, z);
        next += at(x, y, z) * at(x + 1, y, z);
        diagonal += at(x, y, z) * at(x + 1, y + 1, z);
      }
  EXPECT_NEAR(std::sqrt(square / tile.size()), 0.02, 0.003);
  EXPECT_NEAR(next / square, 0.5, 0.08);
  EXPECT_NEAR(diagonal / square, 0.25, 0.1);
}

TEST(DetailSpectrum, ChromaGetsASpectrumOfItsOwn) {
  // White lightness, and chroma averaged over 4 × 4 pixels, as in a compressed photograph.
  const auto drawn = test::draw_disks(256, 128, 1, [](int x, int y, int) {
    const float light = 0.03f * noise(x, y, 9), chroma = 0.02f * noise(x / 4, y / 4, 11);
    return Vec3f(Vec3f::Constant(0.5f + light) + chroma * Vec3f(1, 0, -1));
  });
  const Phases p = find_phases(drawn.image, drawn.labels, {});
  constexpr int n = 48;
  std::vector<Vec3f> tile;
  for (std::uint64_t i = 0; i < n * n * n; ++i) {
    Random r(5, 5, i);
    const double x = r.normal(), y = r.normal(), z = r.normal();
    tile.push_back(0.05f * Vec3(x, y, z).cast<float>());
  }
  match_spectrum(tile, n, p, 0);
  double light = 0, light_next = 0, chroma = 0, chroma_next = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const Vec3f &a = tile[static_cast<std::size_t>(z * n + y) * n + x],
                    &b = tile[static_cast<std::size_t>(z * n + y) * n + (x + 1) % n];
        light += a.mean() * a.mean();
        light_next += a.mean() * b.mean();
        chroma += (a.x() - a.z()) * (a.x() - a.z());
        chroma_next += (a.x() - a.z()) * (b.x() - b.z());
      }
  EXPECT_NEAR(std::sqrt(light / tile.size()), 0.03, 0.004);
  EXPECT_NEAR(std::sqrt(chroma / tile.size()), 0.04, 0.006);
  EXPECT_NEAR(light_next / light, 0, 0.1);
  EXPECT_NEAR(chroma_next / chroma, 0.75, 0.12);
}

struct Contrasts {
  Phases phases;
  Detail detail;
};

// The phases of a picture after split_contrasts, and the contrasts of its profiles.
Contrasts contrasts_of(const test::DrawnPicture& drawn, const PhaseOptions& options) {
  Contrasts out{find_phases(drawn.image, drawn.labels, options), {}};
  out.detail.phases.resize(out.phases.pixels.size());
  split_contrasts(out.phases, drawn.image, drawn.labels, out.detail);
  return out;
}

TEST(DetailRims, ChromaAndGrayHaveContrastsOfTheirOwn) {
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    if (id == 0) return Vec3f(0.5f, 0.5f, 0.5f);
    const float hue = (id % 2 ? 0.04f : 0.01f) * noise(x, y, 5);
    return Vec3f(Vec3f::Constant(0.4f + 0.02f * noise(x, y, 6)) + hue * Vec3f(1, 0, -1));
  });
  const Detail d = contrasts_of(drawn, {.groups = 1}).detail;
  ASSERT_EQ(d.profile_contrast.size(), 16u);
  EXPECT_NEAR(d.profile_contrast[0].y() / d.profile_contrast[1].y(), 4, 0.3);
  EXPECT_NEAR(d.profile_contrast[0].x() / d.profile_contrast[1].x(), 1, 0.1);
  EXPECT_NEAR(d.profile_size[0], 60 * 0.1, 0.05);
}

TEST(DetailRims, ZonesDoNotCountAsGrain) {
  // The same grain in all disks, and in odd ones zones that are wider than grain.
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    if (id == 0) return Vec3f(0.5f, 0.5f, 0.5f);
    const float zone = id % 2 ? 0.06f * std::sin(0.1f * static_cast<float>(x)) : 0;
    return Vec3f(Vec3f::Constant(0.4f + zone + 0.02f * noise(x, y, 5)));
  });
  const Detail d = contrasts_of(drawn, {.groups = 1}).detail;
  ASSERT_EQ(d.profile_contrast.size(), 16u);
  ASSERT_EQ(d.profile_broad.size(), 16u);
  EXPECT_EQ(d.profile_group, std::vector<std::int32_t>(16, 1));
  EXPECT_NEAR(d.profile_contrast[0].x() / d.profile_contrast[1].x(), 1, 0.12);
  EXPECT_GT(d.profile_broad[0].x() / d.profile_broad[1].x(), 2.5);
}

TEST(DetailRims, GrayPicturesHaveNoChromaToDivideBy) {
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    return Vec3f(Vec3f::Constant((id ? 0.4f : 0.7f) + 0.02f * noise(x, y, 5)));
  });
  const auto [p, d] = contrasts_of(drawn, {});
  for (const auto& c : d.profile_contrast) EXPECT_TRUE(c.allFinite());
  for (const Vec3f& v : p.offset) ASSERT_TRUE(v.allFinite());
}

TEST(DetailRims, PixelsNearOutlinesAreLeftOutWhileEnoughRemain) {
  const auto large = test::draw_disks(320, 80, 30, two_colors),
             small = test::draw_disks(160, 40, 12, two_colors);
  for (const auto* drawn : {&large, &small}) {
    PhaseOptions choice;
    choice.groups = 1;
    Phases p = find_phases(drawn->image, drawn->labels, choice);
    const Phases before = p;
    keep_deep_pixels(p, drawn->labels);
    std::vector<std::size_t> left(p.pixels.size(), 0);
    for (std::size_t i = 0; i < p.phase.size(); ++i) {
      EXPECT_TRUE(p.phase[i] == -1 || p.phase[i] == before.phase[i]);
      if (p.phase[i] >= 0) ++left[static_cast<std::size_t>(p.phase[i])];
    }
    EXPECT_EQ(left, p.pixels);
    for (std::size_t k = 0; k < left.size(); ++k)
      EXPECT_GE(left[k], std::min<std::size_t>(4000, before.pixels[k]));
    if (drawn == &large) {
      EXPECT_LT(left[1], before.pixels[1]);
      EXPECT_EQ(p.phase[40 * 320 + 40], 1);        // a disk's middle
      EXPECT_EQ(p.phase[40 * 320 + 40 + 28], -1);  // 2 pixels from its outline
    }
  }
}

// A strip narrower than a patch, and a picture of one color, have no grain; neither is an error.
TEST(DetailTiles, PicturesWithoutTextureGiveNoGrain) {
  for (const auto& [width, height, contrast] : {std::tuple{400, 6, 0.1f}, {64, 64, 0.0f}}) {
    Image image(width, height, 1, 0.1);
    Labels labels;
    labels.width = width;
    labels.height = height;
    labels.ids.assign(image.pixels.size(), 0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        image.at(x, y) = Vec3f::Constant(0.3f + contrast * std::tanh(noise(x, y, 2)));
    const Phases p = find_phases(image, labels, {});
    const auto tile = phase_tile(phase_exemplar(p, 0, 32, 1), 16, 1);
    ASSERT_EQ(tile.size(), 16u * 16 * 16);
    for (const Vec3f& v : tile) ASSERT_LT(v.norm(), 1e-5f);
  }
}

}  // namespace
}  // namespace terrazzo
