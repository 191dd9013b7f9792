#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "nodes/common/geometry/components.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"

namespace terrazzo {
namespace {
using namespace synthetic_photo;

PhotoOptions small(Scene scene, std::uint64_t seed, int pictures = 1) {
  PhotoOptions o;
  o.scene = scene;
  o.seed = seed;
  o.pictures = pictures;
  o.width = 160;
  o.height = 96;
  return o;
}

double labeled_fraction(const Labels& labels) {
  return 1 - static_cast<double>(std::count(labels.ids.begin(), labels.ids.end(), 0)) /
                 static_cast<double>(labels.ids.size());
}

TEST(SyntheticPhoto, APictureDoesNotDependOnHowManyAreTaken) {
  const Photo one = take_photo(small(Scene::Any, 5), {}), three = take_photo(small(Scene::Any, 5, 3), {});
  ASSERT_EQ(three.image.sections, 3);
  EXPECT_TRUE(std::equal(one.image.pixels.begin(), one.image.pixels.end(), three.image.pixels.begin()));
  EXPECT_TRUE(std::equal(one.labels.ids.begin(), one.labels.ids.end(), three.labels.ids.begin()));
  EXPECT_FALSE(std::equal(one.image.pixels.begin(), one.image.pixels.end(),
                          three.image.pixels.begin() + static_cast<std::ptrdiff_t>(one.image.pixels.size())));
}

// Every label is one piece that is large enough to be seen, on material, and ids run without gaps.
TEST(SyntheticPhoto, LabelsAreSingleVisiblePieces) {
  for (const Scene scene : {Scene::Bank, Scene::Heap, Scene::Section, Scene::Alloy})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Photo photo = take_photo(small(scene, seed), {});
      ASSERT_EQ(photo.labels.ids.size(), photo.image.pixels.size());
      ASSERT_EQ(photo.not_material.ids.size(), photo.image.pixels.size());
      const Components parts =
          connected_components(photo.labels.ids, photo.labels.width, photo.labels.height, false);
      EXPECT_EQ(parts.count(), photo.labels.count()) << "seed " << seed;
      for (const auto size : parts.sizes)
        EXPECT_GE(size, scene == Scene::Section || scene == Scene::Alloy ? 14 : 40);
      EXPECT_EQ(
          photo.labels.ids.empty() ? 0 : *std::max_element(photo.labels.ids.begin(), photo.labels.ids.end()),
          photo.labels.count());
      for (const Vec3f& c : photo.image.pixels) ASSERT_TRUE(c.minCoeff() >= 0 && c.maxCoeff() <= 1);
    }
}

// Particles without a label are marked, never together with one, and there are some of them.
TEST(SyntheticPhoto, UnclearParticlesHaveNoLabel) {
  std::size_t unclear = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Photo photo = take_photo(small(Scene::Bank, seed), {});
    ASSERT_EQ(photo.unclear.ids.size(), photo.labels.ids.size());
    for (std::size_t i = 0; i < photo.labels.ids.size(); ++i) {
      ASSERT_TRUE(photo.unclear.ids[i] == 0 || photo.labels.ids[i] == 0);
      unclear += photo.unclear.ids[i] != 0;
    }
    all += photo.labels.ids.size();
  }
  EXPECT_GT(unclear, 0u);
  EXPECT_LT(unclear, all / 4);
}

TEST(SyntheticPhoto, FillSetsTheAreaFractionOfSections) {
  for (const double fill : {0.1, 0.3, 0.5, 0.8}) {
    double sum = 0;
    const int pictures = 8;
    for (int seed = 1; seed <= pictures; ++seed) {
      PhotoOptions o = small(Scene::Section, static_cast<std::uint64_t>(seed));
      o.width = o.height = 192;
      o.fill = fill;
      o.objects = false;
      sum += labeled_fraction(take_photo(o, {}).labels);
    }
    EXPECT_NEAR(sum / pictures, fill, 0.13) << fill;
  }
}

TEST(SyntheticPhoto, ObjectsAreMarkedAndCoverLabels) {
  PhotoOptions o = small(Scene::Any, 11, 60);
  o.width = o.height = 64;
  const Photo with = take_photo(o, {});
  o.objects = false;
  const Photo without = take_photo(o, {});
  EXPECT_EQ(std::count(without.not_material.ids.begin(), without.not_material.ids.end(), 1), 0);
  // Labels have the majority of four canvas pixels, marks the first of them, so they may share a rim.
  std::size_t marked = 0, both = 0;
  for (std::size_t i = 0; i < with.labels.ids.size(); ++i) {
    marked += with.not_material.ids[i] != 0;
    both += with.not_material.ids[i] != 0 && with.labels.ids[i] != 0;
  }
  EXPECT_LT(both, marked / 20);
  EXPECT_GT(marked, with.labels.ids.size() / 200);
  EXPECT_LT(marked, with.labels.ids.size() / 3);
}

}  // namespace
}  // namespace terrazzo
