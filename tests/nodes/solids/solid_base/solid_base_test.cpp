// Decoding the base from bytes: complete, truncated and damaged.
#include "nodes/solids/synthesis/solid_base.h"

#include <gtest/gtest.h>

#include "graph/diagnostic.h"
#include "nodes/data/image.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/solids/solid_optimize/exemplars.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

const std::vector<char>& stored() {
  static const std::vector<char> bytes = [] {
    const auto run =
        test::run_node("SolidBase",
                       {{"exemplar", Value::of<Image>(test::blobs(32, 32, 8, 1))},
                        {"features", Value::of<Image>(test::blobs(32, 32, 5, 2))}},
                       {{"size", "24"}, {"levels", "2"}, {"iterations", "1"}, {"planes", "[x, y, z]"}});
    BufferWriter w;
    value_type<SolidBase>().encode(&run.output<SolidBase>("base"), w);
    return w.buffer;
  }();
  return bytes;
}

// Whether the bytes could be read. If they are rejected, the error code must be "damaged".
bool is_read(const std::vector<char>& bytes) {
  try {
    Reader r(bytes.data(), bytes.size());
    value_type<SolidBase>().decode(r);
    return true;
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "damaged");
    return false;
  }
}

TEST(SolidBase, ComesBackFromItsBytes) {
  Reader r(stored().data(), stored().size());
  const auto back = std::static_pointer_cast<const SolidBase>(value_type<SolidBase>().decode(r));
  EXPECT_EQ(r.left(), 0u);
  EXPECT_EQ(back->request.settings.size, Vec3i::Constant(24));
  EXPECT_TRUE(back->request.settings.method == solids::SolidMethod::Blockwise);
  EXPECT_EQ(back->request.exemplars.at(0).features.size(), 32u * 32);
  EXPECT_EQ(back->base.whole.families.size(), 3u);
  BufferWriter again;
  value_type<SolidBase>().encode(back.get(), again);
  EXPECT_EQ(again.buffer, stored());
}

TEST(SolidBase, CutShortItIsRefused) {
  for (std::size_t k = 0; k < 300; ++k) {
    std::vector<char> bytes = stored();
    bytes.resize(Random(1, 0, k).below(bytes.size()));
    EXPECT_FALSE(is_read(bytes)) << bytes.size();
  }
}

TEST(SolidBase, DamagedItIsRefusedOrRead) {
  std::size_t refused = 0;
  for (std::size_t k = 0; k < 2000; ++k) {
    std::vector<char> bytes = stored();
    // Mostly near the shapes, because lists of numbers accept any values.
    Random random(2, 0, k);
    const std::size_t at = random.below(k % 2 ? bytes.size() : 300);
    bytes[at] = static_cast<char>(random.bits());
    refused += !is_read(bytes);
  }
  EXPECT_GT(refused, 10u);
}

}  // namespace
}  // namespace terrazzo
