// Geometry that is kept while colors change.
#include <gtest/gtest.h>

#include "nodes/data/detail.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/voxelize/voxelize.h"
#include "runtime/cache/store.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/arithmetic.h"

namespace terrazzo {
namespace {

// Many overlapping particles, some of them voids, that reach beyond the box.
Particles colored(std::uint64_t seed, bool voids) {
  Particles p;
  p.box = Vec3(4, 4, 8);
  p.resize(40);
  if (voids) {
    p.voids.assign(40, 0);
    p.voids[3] = p.voids[17] = 1;
  }
  for (std::size_t i = 0; i < 40; ++i) {
    Random place(1, 0, i), color(seed, 1, i);
    p.position[i] = p.box.cwiseProduct(Vec3(place.uniform(), place.uniform(), place.uniform()));
    p.scale[i] = 0.4 + place.uniform();
    p.orientation[i] = test::random_turn(place);
    for (int k = 0; k < 3; ++k) p.color[i][k] = static_cast<float>(color.uniform());
    p.cls[i] = static_cast<std::int32_t>(color.below(3));
  }
  Random binder(seed, 2, 0);
  p.binder_color = Vec3f::Constant(static_cast<float>(binder.uniform()));
  return p;
}

// Noise, rims and factors that tell phases, places and distances apart.
Detail fine_detail() {
  Detail d;
  d.pixel_size = 0.3;
  d.size = 6;
  for (std::uint64_t k = 0; k < 3; ++k) {
    Detail::Phase phase;
    phase.color = Vec3f::Constant(0.1f + 0.35f * static_cast<float>(k));
    phase.slope = k == 0 ? 0 : 0.05f;
    phase.gain = {0.5f, 0.8f, 1};
    phase.rims = {{0.5f, {Vec3f(0.02f, 0, 0), Vec3f::Zero()}}, {2, {Vec3f(0, 0.04f, 0), Vec3f::Zero()}}};
    for (std::uint64_t i = 0; i < 216; ++i)
      phase.tile.push_back(Vec3f::Constant(static_cast<float>(0.1 * Random(1, k, i).normal())));
    d.phases.push_back(std::move(phase));
  }
  return d;
}

Hash content(const Volume& v) {
  HashWriter w;
  value_type<Volume>().encode(&v, w);
  return w.hash();
}

// Colors of any packing give the same bits on kept geometry, and other geometry is never taken for it.
TEST(Voxelize, KeptGeometryGivesTheBitsOfAFreshVoxelization) {
  Store store(test::value_types(), {}, 1 << 30);
  const Intermediates kept(store);
  for (const bool voids : {false, true})
    for (const std::uint64_t seed : {1, 2, 3}) {
      Particles p = colored(seed, voids);
      Shapes shapes = test::shapes_of(test::cube_mesh());
      for (int change = 0; change < 6; ++change) {
        if (change == 1) p.position[5].x() = 0.3;
        if (change == 2) p.scale[6] *= 1.1;
        if (change == 3) p.orientation[7] = p.orientation[8];
        if (change == 4) shapes.shapes[0].mesh.vertices[0] *= 1.01;
        const std::int64_t n = change == 5 ? 12 : 16;
        voxelize::VoxelReport again, fresh;
        const voxelize::Lattice lattice = voxelize::choose_lattice(p.box, {n, n, 2 * n});
        EXPECT_EQ(content(voxelize::voxelize(p, shapes, nullptr, lattice, again, {}, nullptr, kept)),
                  content(voxelize::voxelize(p, shapes, nullptr, lattice, fresh)))
            << voids << seed << change;
        EXPECT_EQ(again.volume_fraction, fresh.volume_fraction);
        EXPECT_EQ(again.overlap_fraction, fresh.overlap_fraction);
        EXPECT_GT(fresh.overlap_fraction, 0);
      }
    }
}

// The binder's detail is kept too; that of other tiles, or behind other particles, is never taken for it.
TEST(Voxelize, KeptDetailGivesTheBitsOfAFreshVoxelization) {
  Store store(test::value_types(), {}, 1 << 30);
  const Intermediates kept(store);
  Detail detail = fine_detail();
  const Shapes shapes = test::shapes_of(test::cube_mesh());
  Hash last{};
  for (int change = 0; change < 5; ++change) {
    Particles p = colored(static_cast<std::uint64_t>(change) + 1, change == 4);
    p.size.assign(p.count(), 1.2);
    if (change == 2) detail.phases[0].tile[7].x() += 0.2f;
    if (change == 3) p.size[4] = 0.4;
    const voxelize::Lattice lattice = voxelize::choose_lattice(p.box, {16, 16, 32});
    voxelize::VoxelReport again, fresh;
    const Hash known = content(voxelize::voxelize(p, shapes, nullptr, lattice, again, {}, &detail, kept));
    EXPECT_EQ(known, content(voxelize::voxelize(p, shapes, nullptr, lattice, fresh, {}, &detail))) << change;
    EXPECT_NE(known, last);
    last = known;
  }
}

}  // namespace
}  // namespace terrazzo
