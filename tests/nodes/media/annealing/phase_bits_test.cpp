#include "nodes/media/annealing/phase_bits.h"

#include <gtest/gtest.h>

#include "runtime/random.h"

namespace terrazzo::annealing {
namespace {

// Lines shorter than the reach repeat more than once within it.
TEST(MediaSolid, BitsShowWhatIsAroundAVoxelOfALineThatRepeats) {
  Random random(1);
  for (int length = 4; length <= 40; ++length) {
    std::vector<bool> in(3 * length);
    PhaseBits bits(length, 3);
    for (int i = 0; i < 20 * length; ++i) {
      const std::size_t at = random.below(in.size());
      in[at] = random.below(2);
      bits.set(at / length, static_cast<int>(at % length), in[at]);
    }
    for (int line = 0; line < 3; ++line)
      for (int at = 0; at < length; ++at) {
        const std::uint32_t around = bits.around(line, at);
        for (int d = -PhaseBits::kReach; d <= PhaseBits::kReach; ++d) {
          const int wrapped = (at + d + 4 * length) % length;
          ASSERT_EQ(around >> (PhaseBits::kReach + d) & 1, in[line * length + wrapped])
              << length << " " << line << " " << at << " " << d;
        }
      }
  }
}

}  // namespace
}  // namespace terrazzo::annealing
