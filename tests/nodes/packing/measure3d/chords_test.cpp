// Chord lengths against closed forms, in volumes that tile and in parts of them.
#include "nodes/packing/measure3d/chords.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/nodes/packing/measure3d/blocks.h"

namespace terrazzo {
namespace {
using namespace measure3d;

// Share of the chords with more than k voxels.
double beyond(const ChordLengths& chords, std::size_t k) {
  double sum = 1;
  for (std::size_t i = 0; i <= k && i < chords.share.size(); ++i) sum -= chords.share[i];
  return sum;
}

TEST(Measure3DChords, OfABallAreFourThirdsOfItsRadiusOnAverage) {
  const Vec3 spacing(0.5, 0.4, 0.3);
  const double radius = 6;
  for (const double shift : {0.1, 3.3}) {  // the second ball wraps
    const auto c = test::classes_of({36, 44, 60}, spacing, true, [&](int x, int y, int z) {
      const Vec3 p = (Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing);
      return nearest_image(p - Vec3::Constant(9 + 3 * shift), Vec3(18, 17.6, 18)).norm() < radius ? 1 : 0;
    });
    const auto chords = chord_lengths(c, {});
    for (int a = 0; a < 3; ++a) {
      const auto& found = chords[1][static_cast<std::size_t>(a)];
      EXPECT_NEAR(found.mean / (4 * radius / 3), 1, 0.02) << a;
      // Of lines through a disk, r²/4 of its area is within half of the radius: chords longer than √3·r.
      const auto longest = static_cast<std::size_t>(std::sqrt(3.0) * radius / spacing[a]);
      EXPECT_NEAR(beyond(found, longest), 0.25, 0.06) << a;  // a chord is of whole voxels
      EXPECT_NEAR(beyond(found, 1000), 0, 1e-9);
    }
  }
}

// The pores of a Boolean model: a chord ends where a ball begins, and it meets λπr² balls per length.
TEST(Measure3DChords, OfThePoresOfABooleanModelAreExponential) {
  constexpr int n = 80, count = 500, kSeeds = 6;
  constexpr double radius = 6, rate = count * M_PI * radius * radius / (n * n * n);
  double mean = 0, quarter = 0;
  for (std::uint64_t seed = 10; seed < 10 + kSeeds; ++seed) {
    const auto chords =
        chord_lengths(classes_of_phase(test::boolean_model(n, radius, count, seed), Phase::Particles), {});
    for (const ChordLengths& along : chords[0]) {
      mean += along.mean / kSeeds / 3;
      quarter += beyond(along, 12) / kSeeds / 3;
    }
  }
  // Voxels miss the shortest pores: chords of less than one voxel, and balls that touch.
  EXPECT_NEAR(mean * rate, 1, 0.06);
  EXPECT_NEAR(quarter, std::exp(-12 * rate), 0.02);
}

TEST(Measure3DChords, CutByTheBorderAreCountedByHand) {
  // Lengths 2 (complete), 1 (complete), 3 (cut) of class 1; 1 (cut), 1, 1 of class 0.
  const int line[] = {0, 1, 1, 0, 1, 0, 1, 1, 1};
  const auto chords = chord_lengths(
      test::classes_of({9, 1, 1}, Vec3::Constant(2), false, [&](int x, int, int) { return line[x]; }), {});
  // 12 mm of 18 are inside; there are 5 ends in the 16 mm between the first and last voxel.
  EXPECT_NEAR(chords[1][0].mean, 12.0 / 18 / (2.5 / 16), 1e-12);
  ASSERT_EQ(chords[1][0].share.size(), 3u);
  EXPECT_NEAR(chords[1][0].share[1], 2.0 / 5, 1e-12);              // 2 of 5 ends, all longer than 1 seen
  EXPECT_NEAR(chords[1][0].share[2], 3.0 / 5 * (2.0 / 3), 1e-12);  // 2 of the 3 that go on
  EXPECT_NEAR(beyond(chords[1][0], 2), 1.0 / 5, 1e-12);            // the one that is cut
  EXPECT_TRUE(std::isnan(chords[1][1].mean));                      // no end along y
  EXPECT_TRUE(chords[1][1].share.empty());
}

// Slices of 16 voxels cut most chords that are 15 voxels long on average.
TEST(Measure3DChords, CutByTheBorderHaveTheLengthsOfTheWhole) {
  constexpr int n = 96, kPart = 16;
  const Raster whole = test::boolean_model(n, 4, 1200, 3);
  const auto in = [&](int x, int y, int z) { return whole.in[whole.index(x, y, z)]; };
  const auto all = chord_lengths(test::classes_of(whole.box.size, Vec3::Ones(), true, in), {});
  double mean = 0;
  std::vector<double> found(kPart - 1, 0);
  constexpr int kStep = 3, kParts = n / kStep;
  for (int part = 0; part < n; part += kStep) {
    const auto chords =
        chord_lengths(test::classes_of({kPart, n, n}, Vec3::Ones(), false,
                                       [&](int x, int y, int z) { return in((part + x) % n, y, z); }),
                      {});
    mean += chords[0][0].mean / kParts;
    for (std::size_t k = 0; k < found.size(); ++k) found[k] += beyond(chords[0][0], k) / kParts;
  }
  EXPECT_NEAR(mean / all[0][0].mean, 1, 0.03);
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], beyond(all[0][0], k), 0.02) << k;
  EXPECT_GT(found.back(), 0.3);  // are longer than any complete one
}

}  // namespace
}  // namespace terrazzo
