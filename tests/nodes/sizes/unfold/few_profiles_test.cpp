// Photographs with few profiles: either a finite distribution, or an error that states how many are needed.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/random.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace unfolding;

// Sections of spheres with diameters between 2 and 10 mm, 80 mm² per profile.
Profiles section(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Profiles p;
  p.observed_area = 80 * static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    double d;
    do d = random.uniform(2, 10);
    while (random.uniform() * 10 > d);
    const double h = random.uniform(0, d / 2);
    Profile q;
    q.area = std::numbers::pi * (d * d / 4 - h * h);
    p.area_fraction += q.area / p.observed_area;
    p.profiles.push_back(q);
  }
  return p;
}

bool finite(const UnfoldResult& r) {
  bool all = std::isfinite(r.distribution.volume_fraction) && std::isfinite(r.distribution.goodness_of_fit);
  for (const auto& e : r.distribution.shapes)
    for (const auto* values : {&e.N_V, &e.low, &e.high})
      for (const double v : *values) all = all && std::isfinite(v) && v >= 0;
  return all;
}

// The result for `p`: "" for a finite distribution, otherwise the error message.
std::string outcome(const Profiles& p, const UnfoldOptions& o) {
  try {
    return finite(unfold(p, test::spheres<20>(), o, {})) ? "" : "not finite";
  } catch (const Error& e) {
    return e.what();
  }
}

TEST(UnfoldFewProfiles, GiveADistributionOrSayHowManyAreNeeded) {
  for (const std::size_t n : {0u, 1u, 2u, 3u, 4u, 5u, 8u, 17u, 83u})
    for (std::uint64_t seed = 1; seed <= (n < 83 ? 6u : 1u); ++seed)
      for (const bool known : {true, false}) {
        Profiles p = section(n, seed);
        if (!known) p.observed_area = p.area_fraction = 0;
        UnfoldOptions o;
        o.bootstrap = n < 83 && seed < 3 ? 20 : 0;
        const std::string found = outcome(p, o);
        if (n >= 3)
          EXPECT_EQ(found, "") << n << " profiles, seed " << seed << (known ? "" : ", relative");
        else
          EXPECT_NE(found.find(n == 0 ? "there are no profiles" : "needs at least 3 profiles"),
                    std::string::npos)
              << found;
      }
}

// Two colors, one of them with only two profiles; profiles of equal size; the other methods.
TEST(UnfoldFewProfiles, MayBeOfOneSizeOrOfSeveralColors) {
  for (const std::size_t n : {3u, 5u, 17u})
    for (std::uint64_t seed = 1; seed <= 2; ++seed)
      for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls}) {
        UnfoldOptions o;
        o.method = method;
        Profiles p = section(n, seed);
        p.classes = 2;
        p.profiles[0].cls = p.profiles[1].cls = 1;
        EXPECT_EQ(outcome(p, o), "") << n << " profiles, seed " << seed << ", " << static_cast<int>(method);
        p = section(n, seed);
        p.area_fraction = 0.3;
        for (auto& q : p.profiles) q.area = 12;
        EXPECT_EQ(outcome(p, o), "") << n << " equal profiles, " << static_cast<int>(method);
      }
}

}  // namespace
}  // namespace terrazzo
