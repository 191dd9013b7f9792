// How many size classes there are, and where the smallest begins.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/sizes/unfold/limit.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/nodes/sizes/unfold/spheres_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace unfold;
using namespace unfolding;
using test::number;
using test::section;

TEST(Unfold, MissingFinesAreNotTakenForNone) {
  // A photograph that shows nothing below 3 mm, of particles between 1 and 10 mm.
  Profiles p = section(1, 10, 0.001, 1e6, 8);
  std::erase_if(p.profiles, [](const Profile& q) { return q.area < std::numbers::pi / 4 * 9; });
  UnfoldOptions o;
  o.d_max = 10;
  o.smallest_visible = 3;
  const UnfoldResult blind = unfolding::unfold(p, test::spheres<10>(), o, {});
  EXPECT_NEAR(number(blind.distribution, 4, 10) / (0.001 * 6 / 9), 1, 0.1);
  EXPECT_EQ(number(blind.distribution, 0, 3), 0);
  EXPECT_EQ(blind.distribution.class_edges[static_cast<std::size_t>(blind.model.first)], 3);
}

TEST(Unfold, FewProfilesGetFewerClassesAndAWarning) {
  Profiles p = section(5, 10, 0.001, 1e5, 3);
  p.profiles.resize(40);
  p.area_fraction = 0;
  p.observed_area = 1e4;
  const auto classes_and_warnings = [&](const std::string& classes) {
    const auto run =
        test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", Value::of(test::spheres<10>())}},
                       {{"bootstrap", "0"}, {"classes", classes}, {"method", "nnls"}});
    return std::pair(run.output<SizeDistribution>("distribution").classes(), run.warnings.size());
  };
  EXPECT_EQ(classes_and_warnings("auto"), std::pair(std::size_t{6}, std::size_t{1}));
  EXPECT_EQ(classes_and_warnings("10"), std::pair(std::size_t{10}, std::size_t{0}));
  EXPECT_EQ(classes_and_warnings("60").second, 1u);  // fewer profiles than classes
}

// Many particles of half a millimeter to one beside few of 6 to 14 mm.
Profiles small_beside_large() {
  Profiles p = section(0.5, 1, 0.03, 1e4, 4);
  const Profiles large = section(6, 14, 0.0003, 1e4, 5);
  p.profiles.insert(p.profiles.end(), large.profiles.begin(), large.profiles.end());
  p.area_fraction += large.area_fraction;
  return p;
}

TEST(Unfold, TheSmallestClassIsDividedWhereSizesDifferMuch) {
  // In one class of 0.4 to 2 mm, whose sizes count as uniform, the same number of small particles would show
  // far more profiles.
  Profiles p = small_beside_large();
  std::erase_if(p.profiles, [](const Profile& q) { return q.area < std::numbers::pi / 4 * 0.16; });
  const double observed = static_cast<double>(p.profiles.size()) / p.observed_area;
  // The profiles of spheres of these sizes, relative to those observed.
  const auto shown = [&](int classes) {
    UnfoldOptions o;
    o.smallest_visible = 0.4;
    o.classes = classes;
    const UnfoldResult r = unfolding::unfold(p, test::spheres<8>(), o, {});
    EXPECT_LT(r.model.edges.back(), 16);
    if (classes == 0) {
      EXPECT_EQ(r.model.equal, 8);
      EXPECT_GT(r.model.classes(), 8);
      for (std::size_t i = 0; r.model.profile_edges[i] < 1; ++i)
        EXPECT_LE(r.model.profile_edges[i + 1], 2 * r.model.profile_edges[i] * (1 + 1e-12));
    } else {
      EXPECT_EQ(r.model.classes(), classes);
    }
    double sum = 0;
    for (int j = 0; j < r.model.visible(); ++j)
      sum += r.fits[0].density[j] * r.model.matrix.col(j).sum() / observed;
    return sum;
  };
  EXPECT_NEAR(shown(0), 1, 0.15);
  EXPECT_GT(shown(8), 1.5);
}

TEST(Unfold, TheSmallestClassStaysWholeWhereItHoldsFewProfiles) {
  Profiles p = section(6, 14, 0.0005, 1e4, 6);
  p.profiles[0].area = 0.01;
  UnfoldOptions o;
  const UnfoldResult r = unfolding::unfold(p, test::spheres<8>(), o, {});
  EXPECT_LT(r.model.profile_edges[0] * 2, r.model.profile_edges[1]);
  const auto in_first = std::ranges::count_if(p.profiles, [&](const Profile& q) {
    return std::sqrt(4 * q.area / std::numbers::pi) <= r.model.profile_edges[1];
  });
  EXPECT_LT(r.model.equal * in_first, static_cast<std::ptrdiff_t>(p.profiles.size()));
  EXPECT_EQ(r.model.classes(), r.model.equal);
}

// Where small profiles are missing, the fit without the smallest class finds more of the larger particles'
// neighbors in size; where none are missing, it finds the same.
TEST(Unfold, LimitSensitivityShowsMissingSmallProfiles) {
  const auto effect = [](const Profiles& p) {
    UnfoldOptions o;
    o.d_max = 10;
    o.smallest_visible = 1;
    const auto s =
        limit_sensitivity(p, test::spheres<10>(), o, unfolding::unfold(p, test::spheres<10>(), o, {}), {});
    EXPECT_TRUE(s.has_value());
    return s.value_or(LimitSensitivity{});
  };
  const Profiles all = section(1, 10, 0.001, 4e5, 3);
  const LimitSensitivity good = effect(all);
  EXPECT_NEAR(good.change, 0, 0.03);
  EXPECT_NEAR(good.share, 1.0 / 9, 0.05);
  Profiles few = all;  // of the profiles below 2 mm, one in ten is seen
  std::size_t k = 0;
  std::erase_if(few.profiles, [&](const Profile& q) { return q.area < std::numbers::pi && k++ % 10 != 0; });
  EXPECT_GT(effect(few).change, good.change + 0.02);
  EXPECT_FALSE(limit_sensitivity(
                   all, test::spheres<10>(), {.classes = 2, .smallest_visible = 1},
                   unfolding::unfold(all, test::spheres<10>(), {.classes = 2, .smallest_visible = 1}, {}), {})
                   .has_value());
}

}  // namespace
}  // namespace terrazzo
