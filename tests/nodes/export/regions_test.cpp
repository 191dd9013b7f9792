// Numbers of the materials in files of voxels, and base64.
#include "nodes/export/regions.h"

#include <gtest/gtest.h>

#include <sstream>

#include "runtime/files/base64.h"
#include "runtime/random.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace exporting;
using test::code_of;

TEST(Regions, AreNumberedWithoutGaps) {
  const Volume v = test::formula_volume();
  const Particles p = test::formula_particles();
  const VoxelBox box = voxel_box(v);
  const VoxelSource id(v, "id", box);
  const Regions r = find_regions(id, box, &p, RegionKind::Particles, {});
  ASSERT_EQ(r.all.size(), 7u);  // binder and six particles: particle 4 has no voxel
  EXPECT_EQ(r.of_particle, (std::vector<std::int32_t>{1, 2, 3, 4, -1, 5, 6}));
  EXPECT_EQ(r.all[4].name(), "VOID_3");
  EXPECT_EQ(r.all[5].name(), "PARTICLE_5");
  EXPECT_EQ(r.all[5].cls, 2);
  EXPECT_EQ(r.all[5].phase, 3);
  EXPECT_EQ(r.phase(3), 4);  // voids come after the last class
  std::size_t voxels = 0, binder = 0;
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) binder += test::formula_id(x, y, z) < 0;
  for (const Region& region : r.all) voxels += region.voxels;
  EXPECT_EQ(voxels, 120u);
  EXPECT_EQ(r.all[0].voxels, binder);

  const Regions phases = find_regions(id, box, &p, RegionKind::Phases, {});
  ASSERT_EQ(phases.all.size(), 5u);
  EXPECT_EQ(phases.number(3), 4);
  EXPECT_EQ(phases.number(6), 1);
  EXPECT_EQ(phases.all[4].name(), "VOIDS");
  const Regions plain = find_regions(id, box, nullptr, RegionKind::Particles, {});
  EXPECT_EQ(plain.all.size(), 7u);
  EXPECT_EQ(plain.phase(3), 1);

  const Table table = region_table(r, box, &p);
  double fraction = 0;
  for (std::size_t row = 0; row < table.rows.size(); ++row) fraction += table.number(row, "fraction");
  EXPECT_NEAR(fraction, 1, 1e-12);
  EXPECT_NEAR(table.number(0, "volume mm³"), double(binder) * 0.25 * 0.25 * 0.25, 1e-12);
}

TEST(Regions, RefuseParticlesOfAnotherPacking) {
  const Volume v = test::formula_volume();
  const VoxelBox box = voxel_box(v);
  const VoxelSource id(v, "id", box), density(v, "density", box);
  Particles p = test::formula_particles();
  p.resize(6);
  EXPECT_EQ(code_of([&] { find_regions(id, box, &p, RegionKind::Particles, {}); }), "size-mismatch");
  EXPECT_EQ(code_of([&] { find_regions(id, box, nullptr, RegionKind::Phases, {}); }), "missing-input");
  EXPECT_EQ(code_of([&] { find_regions(density, box, nullptr, RegionKind::Particles, {}); }), "no-id");
}

TEST(Base64, EncodesAndDecodesAnyLength) {
  // RFC 4648, section 10
  const std::map<std::string, std::string> known = {{"", ""},
                                                    {"f", "Zg=="},
                                                    {"fo", "Zm8="},
                                                    {"foo", "Zm9v"},
                                                    {"foob", "Zm9vYg=="},
                                                    {"fooba", "Zm9vYmE="},
                                                    {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : known) {
    std::ostringstream out;
    Base64Writer writer(out);
    writer.write(bytes.data(), bytes.size());
    writer.finish();
    EXPECT_EQ(out.str(), text);
    std::string back;
    EXPECT_TRUE(decode_base64(text, back));
    EXPECT_EQ(back, bytes);
  }
  std::string bytes;
  for (int i = 0; i < 20000; ++i) bytes += static_cast<char>(Random(1, 1, i).below(256));
  std::ostringstream out;
  Base64Writer writer(out);
  for (std::size_t at = 0, piece = 0; at < bytes.size(); at += piece) {
    piece = std::min<std::size_t>(1 + Random(2, 2, at).below(5000), bytes.size() - at);
    writer.write(bytes.data() + at, piece);
  }
  writer.finish();
  std::string back;
  EXPECT_TRUE(decode_base64(out.str(), back));
  EXPECT_EQ(back, bytes);
  for (const char* bad : {"Zg=", "Z", "Zm9v!", "===="}) EXPECT_FALSE(decode_base64(bad, back)) << bad;
}

}  // namespace
}  // namespace terrazzo
