// The default ranges of the classes compared with independent masks of a real scan.
#include <gtest/gtest.h>

#include "nodes/data/volume.h"
#include "nodes/volumes/render_volume/tissue.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace render_volume;

openvdb::FloatGrid::ConstPtr load(const std::filesystem::path& path) {
  return test::run_node("LoadVolume", {}, {{"path", path.string()}})
      .output<Volume>("volume")
      .find<openvdb::FloatGrid>("density");
}

// Only where a voxel and all its neighbors are in the mask, since Hounsfield units are ambiguous elsewhere.
TEST(SharedScan, ClassesAgreeWithTheMasks) {
  const auto folder = test::shared_data() / "volumes";
  if (!std::filesystem::exists(folder / "abdomen_ct.nii.gz"))
    GTEST_SKIP() << "the shared data are not available";
  const auto tissues = render_volume::parse_tissues({"fat -190 -30", "muscle -30 150"});
  const auto scan = load(folder / "abdomen_ct.nii.gz");
  const struct {
    const char *file, *tissue;
  } masks[] = {{"abdomen_skeletal_muscle.nii.gz", "muscle"},
               {"abdomen_subcutaneous_fat.nii.gz", "fat"},
               {"abdomen_torso_fat.nii.gz", "fat"}};
  for (const auto& m : masks) {
    const auto mask = load(folder / m.file);
    int all = 0, agree = 0, inner = 0, inner_agree = 0;
    for (auto it = mask->cbeginValueOn(); it; ++it) {
      if (*it <= 0) continue;
      const openvdb::Coord at = it.getCoord();
      bool inside = true;
      for (int k = 0; k < 6; ++k) {
        openvdb::Coord next = at;
        next[k / 2] += k % 2 ? 1 : -1;
        inside = inside && mask->tree().getValue(next) > 0;
      }
      const float v = scan->tree().getValue(at);
      bool same = false;
      for (const auto& t : tissues) same = same || (t.name == m.tissue && v >= t.low && v < t.high);
      ++all, agree += same, inner += inside, inner_agree += same && inside;
    }
    EXPECT_GT(double(agree), 0.94 * all) << m.file;
    EXPECT_GT(double(inner_agree), 0.97 * inner) << m.file;
    EXPECT_GT(inner, 10000) << m.file;
  }
}

}  // namespace
}  // namespace terrazzo
