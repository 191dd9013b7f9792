// Base64 (RFC 4648, with padding), piece by piece.
#pragma once

#include <array>
#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>

namespace terrazzo {

// Encodes a sequence of bytes that arrives in pieces. Call finish() after the last one.
class Base64Writer {
 public:
  explicit Base64Writer(std::ostream& out) : out_(out) {}
  void write(const void* data, std::size_t size);
  void finish();

 private:
  std::ostream& out_;
  std::array<unsigned char, 3> rest_{};
  std::size_t waiting_ = 0;  // bytes in rest_
};

std::string encode_base64(std::string_view bytes);

// Decodes text whose length is a multiple of four; blanks and line ends are skipped. Padding ends the text.
// Returns false if it contains anything else.
bool decode_base64(std::string_view text, std::string& bytes);

}  // namespace terrazzo
