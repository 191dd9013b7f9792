// Eigen splits products of large matrices into blocks that fit the processor's caches, and the blocks decide
// in which order sums are taken. Fixed sizes give the same bits on processors with other caches.
#include <Eigen/Core>

namespace terrazzo {
namespace {

constexpr std::ptrdiff_t kLevel1 = 32 << 10, kLevel2 = 512 << 10, kLevel3 = 8 << 20;  // bytes

// Set while the library is loaded, before any node runs.
[[maybe_unused]] const bool cache_sizes_are_fixed = [] {
  Eigen::setCpuCacheSizes(kLevel1, kLevel2, kLevel3);
  return true;
}();

}  // namespace
}  // namespace terrazzo
