// 128-bit content hashes (XXH3), and a Writer that computes them.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "runtime/codec.h"

namespace terrazzo {

struct Hash {
  std::uint64_t high = 0, low = 0;
  auto operator<=>(const Hash&) const = default;
  explicit operator bool() const { return high || low; }
  std::string text() const;               // 32 hexadecimal digits
  static Hash parse(const std::string&);  // zero if it is not a valid hash
};

class HashWriter : public Writer {
 public:
  HashWriter();
  ~HashWriter() override;
  void bytes(const void* data, std::size_t size) override;
  Hash hash() const;
  std::uint64_t size() const { return size_; }

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::uint64_t size_ = 0;
};

Hash hash_of(const void* data, std::size_t size);
inline Hash hash_of(const std::string& s) { return hash_of(s.data(), s.size()); }

}  // namespace terrazzo

template <>
struct std::hash<terrazzo::Hash> {
  std::size_t operator()(const terrazzo::Hash& h) const noexcept { return h.low; }
};
