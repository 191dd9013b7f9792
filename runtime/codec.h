// Writer and Reader: the binary encoding of values. The same byte stream is hashed, cached and read back.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "graph/diagnostic.h"

namespace terrazzo {

class Writer {
 public:
  virtual ~Writer() = default;
  virtual void bytes(const void* data, std::size_t size) = 0;

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void pod(const T& v) { bytes(&v, sizeof v); }
  void text(const std::string& s) {
    pod<std::uint64_t>(s.size());
    bytes(s.data(), s.size());
  }
  // Only for elements without padding: padding bytes are undefined and would make the content hash undefined.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void array(const std::vector<T>& v) {
    pod<std::uint64_t>(v.size());
    bytes(v.data(), v.size() * sizeof(T));
  }
  // For Eigen's fixed-size vectors and quaternions, which are plain numbers in memory but not trivially
  // copyable.
  template <class T>
  void raw_array(const std::vector<T>& v) {
    pod<std::uint64_t>(v.size());
    bytes(static_cast<const void*>(v.data()), v.size() * sizeof(T));
  }
};

// Reads the stream of a Writer. Every method throws Error "damaged" instead of reading past the end, and
// never allocates more than the remaining bytes can fill.
class Reader {
 public:
  Reader(const void* data, std::size_t size) : at_(static_cast<const char*>(data)), left_(size) {}

  void bytes(void* out, std::size_t size) {
    if (size > left_) throw Error("damaged", "the stored value ends too early");
    if (size == 0) return;  // `out` may be null then
    std::memcpy(out, at_, size);
    at_ += size;
    left_ -= size;
  }
  template <class T>
  requires std::is_trivially_copyable_v<T> T pod() {
    T v;
    bytes(&v, sizeof v);
    return v;
  }
  std::string text() {
    std::string s(count(1), '\0');
    bytes(s.data(), s.size());
    return s;
  }
  template <class T>
  requires std::is_trivially_copyable_v<T> std::vector<T> array() { return raw_array<T>(); }
  template <class T>
  std::vector<T> raw_array() {
    std::vector<T> v(count(sizeof(T)));
    bytes(static_cast<void*>(v.data()), v.size() * sizeof(T));
    return v;
  }
  // Reads a length. Throws if fewer than length × `element` bytes remain.
  std::size_t count(std::size_t element) {
    const auto n = pod<std::uint64_t>();
    if (n > left_ / (element ? element : 1))
      throw Error("damaged", "the stored value has an impossible length");
    return n;
  }
  std::size_t left() const { return left_; }
  const char* at() const { return at_; }

 private:
  const char* at_;
  std::size_t left_;
};

// Collects the stream in memory.
class BufferWriter : public Writer {
 public:
  void bytes(const void* data, std::size_t size) override {
    const auto* p = static_cast<const char*>(data);
    buffer.insert(buffer.end(), p, p + size);
  }
  std::vector<char> buffer;
};

}  // namespace terrazzo
