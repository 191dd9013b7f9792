#include "runtime/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <charconv>

namespace terrazzo {

std::string Hash::text() const { return fmt::format("{:016x}{:016x}", high, low); }

Hash Hash::parse(const std::string& s) {
  Hash h;
  if (s.size() != 32) return {};
  const auto a = std::from_chars(s.data(), s.data() + 16, h.high, 16);
  const auto b = std::from_chars(s.data() + 16, s.data() + 32, h.low, 16);
  return a.ptr == s.data() + 16 && b.ptr == s.data() + 32 ? h : Hash{};
}

struct HashWriter::State {
  XXH3_state_t* xx = XXH3_createState();
  ~State() { XXH3_freeState(xx); }
};

HashWriter::HashWriter() : state_(std::make_unique<State>()) { XXH3_128bits_reset(state_->xx); }
HashWriter::~HashWriter() = default;
void HashWriter::bytes(const void* data, std::size_t size) {
  XXH3_128bits_update(state_->xx, data, size);
  size_ += size;
}
Hash HashWriter::hash() const {
  const XXH128_hash_t h = XXH3_128bits_digest(state_->xx);
  return {h.high64, h.low64};
}

Hash hash_of(const void* data, std::size_t size) {
  const XXH128_hash_t h = XXH3_128bits(data, size);
  return {h.high64, h.low64};
}

}  // namespace terrazzo
