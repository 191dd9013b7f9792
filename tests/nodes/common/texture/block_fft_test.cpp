// The Fourier transform of a block against its definition.
#include "nodes/common/texture/block_fft.h"

#include <gtest/gtest.h>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

using Block = std::vector<std::complex<float>>;

Block random_block(const Vec3i& size) {
  Block out(voxels_in(size));
  std::uint64_t item = 0;
  for (auto& v : out) {
    Random r(3, 1, item++);
    v = {static_cast<float>(r.uniform() - 0.5), static_cast<float>(r.uniform() - 0.5)};
  }
  return out;
}

// Lines side by side along y and z, and such that are not.
TEST(BlockFft, EqualsTheDefinition) {
  for (const Vec3i& size : {Vec3i(20, 6, 3), Vec3i(1, 7, 16), Vec3i(5, 1, 1)}) {
    const Block given = random_block(size);
    Block found = given;
    transform_block(found, size, false, {});
    for (int c = 0; c < size.z(); ++c)
      for (int b = 0; b < size.y(); ++b)
        for (int a = 0; a < size.x(); ++a) {
          std::complex<double> sum = 0;
          for (int z = 0; z < size.z(); ++z)
            for (int y = 0; y < size.y(); ++y)
              for (int x = 0; x < size.x(); ++x) {
                const double turns = static_cast<double>(a * x) / size.x() +
                                     static_cast<double>(b * y) / size.y() +
                                     static_cast<double>(c * z) / size.z();
                sum +=
                    std::polar(1.0, -2 * M_PI * turns) * std::complex<double>(given[voxel_at(x, y, z, size)]);
              }
          EXPECT_LT(std::abs(std::complex<double>(found[voxel_at(a, b, c, size)]) - sum), 1e-4);
        }
    transform_block(found, size, true, {});
    for (std::size_t i = 0; i < given.size(); ++i)
      EXPECT_LT(std::abs(found[i] / static_cast<float>(given.size()) - given[i]), 1e-6F);
  }
}

}  // namespace
}  // namespace terrazzo
