#include "nodes/cooccurrence/cooccurrence_solid/cooccurrence_solid.h"

#include <gtest/gtest.h>

#include "nodes/common/texture/cooccurrence.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace cooccurrence_solid;

Image pattern(const char* kind, const char* axis) {
  return test::run_node("Pattern", {},
                        {{"kind", kind}, {"axis", axis}, {"width", "64"}, {"height", "64"}, {"scale", "1"}})
      .output<Image>("image");
}

// The slices of a solid across an axis, as pictures.
std::vector<LevelField> slices_across(const LevelField& solid, int axis) {
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  std::vector<LevelField> out;
  for (int k = 0; k < solid.size[axis]; ++k) {
    LevelField f(Vec3i(solid.size[u], solid.size[v], 1));
    for (int row = 0; row < f.size.y(); ++row)
      for (int column = 0; column < f.size.x(); ++column) {
        int at[3];
        at[axis] = k;
        at[u] = column;
        at[v] = f.size.y() - 1 - row;
        f.at[f.index(column, row)] = solid.at[solid.index(at[0], at[1], at[2])];
      }
    out.push_back(std::move(f));
  }
  return out;
}

// Slices cut out as pictures have the matrices of their axis' picture: almost exactly if one body has these
// sections, and nearer than to another axis' matrix if two pictures contradict each other.
TEST(CooccurrenceSolid, SlicesMatchThePictureOfTheirAxis) {
  for (const char* kind : {"fat", "muscle"}) {
    const bool agree = kind[0] == 'f';
    const Image along = pattern(kind, "x"), across = pattern(kind, "z");
    SolidFieldOptions s;
    s.size = Vec3i(32, 28, 36);
    s.levels = 5;
    const SolidFieldResult r = synthesize_solid({&along, &along, &across}, s);
    EXPECT_LT(r.sweeps.back().error, r.noise_error / (agree ? 100 : 10));
    const auto flat = cooccurrence_offsets(s.extent);
    for (int axis = 0; axis < 3; ++axis) {
      const auto have = measure_cooccurrence(slices_across(r.field, axis), r.levels.count(), flat);
      const auto error = [&](const Image& picture) {
        const LevelField f = levels_of(picture, 0, r.levels, {});
        return cooccurrence_error(have, measure_cooccurrence({f}, r.levels.count(), flat));
      };
      const Image &own = axis == 2 ? across : along, &other = axis == 2 ? along : across;
      EXPECT_LT(error(own), agree ? 0.005 : 0.1) << kind << axis;
      if (!agree) {
        EXPECT_LT(error(own), error(other)) << axis;
      }
      EXPECT_NEAR(error(own), r.axis_error[axis], 0.02) << kind << axis;
    }
  }
}

TEST(CooccurrenceSolid, GivesAVolumeAndRefusesBadInput) {
  const Value image = Value::of(pattern("fat", "z"));
  const auto r =
      test::run_node("CooccurrenceSolid", {{"image", image}}, {{"size", "[16, 12, 20]"}, {"sweeps", "2"}});
  const Volume& v = r.output<Volume>("volume");
  EXPECT_EQ(v.resolution, Vec3i(16, 12, 20));
  ASSERT_TRUE(v.find<openvdb::Vec3SGrid>("Cd"));
  EXPECT_EQ(v.find<openvdb::Vec3SGrid>("Cd")->activeVoxelCount(), 16u * 12 * 20);
  const auto code = [&](const Value& picture, std::map<std::string, std::string> p) {
    return test::code_of([&] { test::run_node("CooccurrenceSolid", {{"image", picture}}, p); });
  };
  EXPECT_EQ(code(image, {{"size", "4"}, {"extent", "4"}}), "too-small");
  EXPECT_EQ(code(image, {{"size", "[16, 16]"}}), "bad-value");
  EXPECT_EQ(code(image, {{"size", "1024"}, {"sweeps", "1"}, {"scales", "6"}, {"extent", "8"}}), "too-small");
  EXPECT_EQ(code(Value::of(Image()), {}), "no-pixels");
  EXPECT_EQ(code(Value::of(Image(32, 32, 1, 1)), {}), "one-color");
}

}  // namespace
}  // namespace terrazzo
