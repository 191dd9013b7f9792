#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "nodes/common/texture/quantiles.h"
#include "nodes/common/texture/slice_family.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/detail/residual_synth/exemplar.h"
#include "nodes/detail/residual_synth/start_field.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace residual_synth;

using Complex = std::complex<double>;

std::vector<LaneComplex> random_signal(std::size_t n, std::uint64_t seed) {
  std::vector<LaneComplex> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    Random r(seed, 0, i);
    for (int l = 0; l < 4; ++l)
      out[i].re[l] = static_cast<float>(r.normal()), out[i].im[l] = static_cast<float>(r.normal());
  }
  return out;
}
Complex at(const LaneComplex& c, int lane) { return {c.re[lane], c.im[lane]}; }

TEST(LaneFft, IsTheFourierTransform) {
  for (const int n : {1, 2, 3, 4, 5, 7, 8, 12, 30, 49, 64, 77, 97, 100, 128}) {
    const LaneFft fft(n);
    for (const bool inverse : {false, true}) {
      const auto input = random_signal(n, n);
      auto data = input, scratch = input;
      fft.run(data.data(), scratch.data(), 1, inverse);
      for (int k = 0; k < n; ++k) {
        Complex sum = 0;
        for (int j = 0; j < n; ++j)
          sum += at(input[j], 3) * std::polar(1.0, (inverse ? 2 : -2) * std::numbers::pi * j * k / n);
        ASSERT_LT(std::abs(sum - at(data[k], 3)), 2e-6 * n + 1e-5) << n;
      }
    }
  }
}

TEST(LaneFft, TwoDimensionsComeBack) {
  for (const auto& [w, h] : {std::pair{16, 12}, {9, 25}, {7, 11}, {1, 8}}) {
    const LaneFft2 fft(w, h);
    const auto input = random_signal(fft.count(), 5);
    auto data = input;
    std::vector<LaneComplex> scratch;
    fft.run(data.data(), false, scratch);
    Complex sum = 0;  // coefficient (1, 2) by hand
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        sum += at(input[y * w + x], 1) *
               std::polar(1.0, -2 * std::numbers::pi * (double(x) * (1 % w) / w + double(y) * 2 / h));
    EXPECT_LT(std::abs(sum - at(data[2 * w + 1 % w], 1)), 1e-4);
    fft.run(data.data(), true, scratch);
    for (std::size_t i = 0; i < fft.count(); ++i)
      ASSERT_LT(std::abs(at(data[i], 2) / double(fft.count()) - at(input[i], 2)), 1e-5);
  }
  EXPECT_EQ(fast_size_below(883), 864);
  EXPECT_EQ(fast_even_size_above(13), 16);
}

TEST(Pyramid, IsATightFrameThatKeepsRealSlicesApart) {
  for (const auto& [w, h] : {std::pair{64, 64}, {40, 27}, {21, 33}, {16, 100}}) {
    const int scales = pyramid_scales(std::min(w, h));
    const auto bands = pyramid_bands(w, h, scales);
    const LaneFft2 fft(w, h);
    const auto input = random_signal(fft.count(), 9);  // real and imaginary parts are two slices
    auto spectrum = input;
    std::vector<LaneComplex> scratch;
    fft.run(spectrum.data(), false, scratch);
    std::vector<LaneComplex> sum(fft.count(), LaneComplex{Lane{}, Lane{}});
    // A single slice must have the same band values as one beside another.
    auto alone = input;
    for (auto& c : alone) c.im = Lane{};
    fft.run(alone.data(), false, scratch);
    double energy = 0, expected = 0;
    for (const auto& c : input) expected += std::norm(at(c, 0));
    for (const Band& b : bands) {
      const LaneFft2 crop(b.width, b.height);
      std::vector<LaneComplex> values(crop.count()), single(crop.count());
      extract_band(b, crop, spectrum.data(), fft.count(), values.data(), scratch);
      extract_band(b, crop, alone.data(), fft.count(), single.data(), scratch);
      for (std::size_t i = 0; i < crop.count(); ++i) {
        ASSERT_NEAR(values[i].re[0], single[i].re[0], 1e-4);
        ASSERT_NEAR(single[i].im[0], 0, 1e-4);
        energy += std::norm(at(values[i], 0)) * double(fft.count()) / double(crop.count());
      }
      add_band(b, crop, values.data(), fft.count(), sum.data(), scratch);
    }
    EXPECT_NEAR(energy / expected, 1, 1e-4) << w << "×" << h;
    fft.run(sum.data(), true, scratch);
    for (std::size_t i = 0; i < fft.count(); ++i)
      ASSERT_LT(std::abs(at(sum[i], 1) / double(fft.count()) - at(input[i], 1)), 2e-5);
  }
}

TEST(Quantiles, MatchingGivesTheTargetsDistribution) {
  std::vector<float> target, values;
  for (std::uint64_t i = 0; i < 50000; ++i) {
    Random r(2, 0, i);
    const double e = r.uniform();
    target.push_back(static_cast<float>(-std::log(1 - e)));  // exponential
    values.push_back(static_cast<float>(r.normal() * 3 + 7));
  }
  const Quantiles q = quantiles_of(target);
  EXPECT_NEAR(q.mean, 1, 0.02);
  EXPECT_NEAR(q.deviation, 1, 0.03);
  const auto before = values;
  match_values(values, q, {});
  const Quantiles now = quantiles_of(values);
  EXPECT_NEAR(now.deviation, q.deviation, 0.02);
  for (const double u : {0.0, 0.05, 0.3, 0.5, 0.9, 0.99, 1.0})
    EXPECT_NEAR(now.of(u), q.of(u), 0.03 + 0.05 * q.of(u)) << u;
  for (std::size_t i = 1; i < values.size(); ++i)  // the order is kept
    ASSERT_FALSE(before[i] > before[i - 1] && values[i] < values[i - 1]);
}

TEST(Quantiles, ConstantValuesStayFinite) {
  std::vector<float> flat(100, 2.0f);
  const Quantiles q = quantiles_of(flat);
  EXPECT_EQ(q.deviation, 0);
  match_values(flat, q, {});
  for (const float v : flat) ASSERT_NEAR(v, 2, 1e-5);
}

TEST(StartField, SlicesHaveTheBandsAskedFor) {
  // A picture far from white: noise averaged over boxes of growing size, finest weakest, plus slanted
  // stripes.
  const int n = 128, scales = 3;
  Image picture(n, n, 1, 1);
  for (int level = 0; level < 4; ++level) {
    const int box = 1 << level;
    std::vector<float> white(n * n);
    for (int i = 0; i < n * n; ++i) white[i] = static_cast<float>(Random(4, level, i).normal());
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int v = 0; v < box; ++v)
          for (int u = 0; u < box; ++u)
            picture.at(x, y) +=
                Vec3f::Constant(white[(y + v) % n * n + (x + u) % n] * 0.05f / static_cast<float>(box));
  }
  const Exemplar exemplar = measure_exemplar({picture}, {0, 0, 0}, scales, 4);
  ASSERT_EQ(exemplar.channels, 1);
  const Vec3i size(48, 40, 54);
  const auto names = pyramid_bands(64, 64, scales);
  const auto& bands = exemplar.wanted(0, 0);
  std::vector<SliceFamily> families;
  for (int axis = 0; axis < 3; ++axis) families.emplace_back(size, axis, scales);
  SliceFamily::Workspace space;
  const auto field =
      start_field(fit_power({&bands, &bands, &bands}, scales), size, families, space, 3, 0, {});
  for (int axis = 0; axis < 3; ++axis) {
    const auto ratio = families[axis].deviations(field, bands, space, {});
    for (std::size_t b = 0; b < ratio.size(); ++b)
      EXPECT_NEAR(ratio[b], 1, names[b].scale <= 2 ? 0.08 : 0.3)
          << "axis " << axis << " scale " << names[b].scale;
  }
}

// White noise, smoothed along x.
std::vector<float> streaks(const Vec3i& size) {
  std::vector<float> out(static_cast<std::size_t>(size.prod()));
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::size_t row = i / size.x() * size.x(), x = (i - row + k) % size.x();
      out[i] += static_cast<float>(Random(8, 0, row + x).normal());
    }
  return out;
}

TEST(SliceFamily, DeviationsAreThoseOfTheBandsThemselves) {
  // Slices that do not fill groups of eight, with odd and even sizes.
  for (const Vec3i& size : {Vec3i(24, 20, 13), Vec3i(17, 9, 32)}) {
    const auto volume = streaks(size);
    const int scales = pyramid_scales(size.minCoeff());
    for (int axis = 0; axis < 3; ++axis) {
      const SliceFamily family(size, axis, scales);
      std::vector<Quantiles> unit(family.bands().size());
      for (auto& q : unit) q.deviation = 1;
      SliceFamily::Workspace space;
      const auto told = family.deviations(volume, unit, space, {});
      const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
      const LaneFft2 fft(size[u], size[v]);
      std::vector<double> first(unit.size()), second(unit.size()), count(unit.size());
      std::vector<LaneComplex> scratch;
      for (int s = 0; s < size[axis]; ++s) {
        std::vector<LaneComplex> slice(fft.count(), LaneComplex{Lane{}, Lane{}});
        for (int y = 0; y < size[v]; ++y)
          for (int x = 0; x < size[u]; ++x) {
            Vec3i at;
            at[axis] = s;
            at[u] = x;
            at[v] = y;
            slice[static_cast<std::size_t>(y) * size[u] + x].re[0] =
                volume[(static_cast<std::size_t>(at.z()) * size.y() + at.y()) * size.x() + at.x()];
          }
        fft.run(slice.data(), false, scratch);
        for (std::size_t b = 0; b < unit.size(); ++b) {
          const Band& band = family.bands()[b];
          const LaneFft2 crop(band.width, band.height);
          std::vector<LaneComplex> values(crop.count());
          extract_band(band, crop, slice.data(), fft.count(), values.data(), scratch);
          for (const auto& c : values) first[b] += c.re[0], second[b] += c.re[0] * c.re[0], ++count[b];
        }
      }
      for (std::size_t b = 0; b < unit.size(); ++b) {
        const double mean = first[b] / count[b], deviation = std::sqrt(second[b] / count[b] - mean * mean);
        // Bands that reach the highest frequency of an even size lose a little when made real.
        EXPECT_NEAR(told[b], deviation, 0.03 * deviation) << axis << ' ' << b;
      }
    }
  }
}

TEST(SliceFamily, BalanceGivesBandsTheDeviationsAimedAt) {
  const Vec3i size(32, 24, 40);
  auto volume = streaks(size);
  const SliceFamily family(size, 1, 2);
  std::vector<Quantiles> wanted(family.bands().size());
  std::vector<double> aim(wanted.size());
  SliceFamily::Workspace space;
  for (auto& q : wanted) q.deviation = 1;
  const auto before = family.deviations(volume, wanted, space, {});
  for (std::size_t b = 0; b < wanted.size(); ++b)
    wanted[b].deviation = before[b], aim[b] = family.bands()[b].scale % 2 ? 1.3 : 0.8;
  family.balance(volume, wanted, aim, space, {});
  const auto after = family.deviations(volume, wanted, space, {});
  for (std::size_t b = 0; b < wanted.size(); ++b) EXPECT_NEAR(after[b], aim[b], 0.02) << b;
}

}  // namespace
}  // namespace terrazzo
