// What later computations of a process use again.
#include "runtime/intermediates.h"

#include <gtest/gtest.h>

#include "nodes/data/particles.h"
#include "runtime/cache/store.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/arithmetic.h"

namespace terrazzo {
namespace {

struct Bytes {
  int made;
  std::uint64_t size;
  std::uint64_t bytes() const { return size; }
};

TEST(Intermediates, AreMadeOncePerKeyAndDroppedByMemory) {
  Store store(test::value_types(), {}, 1000);
  const Intermediates kept(store);
  int made = 0;
  const auto get = [&](const Hash& key, std::uint64_t size) {
    return kept.get<Bytes>(key, [&] { return Bytes{++made, size}; });
  };
  EXPECT_EQ(get(key_of("a", 1, Vec3(1, 2, 3)), 400)->made, 1);
  EXPECT_EQ(get(key_of("a", 1, Vec3(1, 2, 3)), 400)->made, 1);
  EXPECT_EQ(get(key_of("b", 1, Vec3(1, 2, 3)), 100)->made, 2);
  EXPECT_EQ(get(key_of("a", 2, Vec3(1, 2, 3)), 100)->made, 3);
  EXPECT_EQ(get(key_of("a", 1, Vec3(1, 2, 4)), 100)->made, 4);
  EXPECT_EQ(get(key_of("large", 0), 2000)->made, 5);  // more than the store keeps
  EXPECT_EQ(get(key_of("large", 0), 2000)->made, 6);
  const Intermediates none;
  for (int k = 0; k < 2; ++k) none.get<Bytes>(key_of("a", 0), [&] { return Bytes{++made, 1}; });
  EXPECT_EQ(made, 8);
}

TEST(Intermediates, AValueInAKeyCountsWithAllItsContent) {
  Particles a = test::one_particle(Vec3::Constant(4), Vec3::Constant(1), 1), b = a;
  EXPECT_EQ(key_of("p", a), key_of("p", b));
  b.color[0].x() += 1e-6f;
  EXPECT_NE(key_of("p", a), key_of("p", b));
}

}  // namespace
}  // namespace terrazzo
