#include "runtime/files/base64.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <sstream>

namespace terrazzo {
namespace {

constexpr std::string_view kBase64Alphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::array<std::int8_t, 256> base64_values() {
  std::array<std::int8_t, 256> values;
  values.fill(-1);
  for (std::size_t i = 0; i < kBase64Alphabet.size(); ++i)
    values[static_cast<unsigned char>(kBase64Alphabet[i])] = i;
  return values;
}

void encode_three(const unsigned char* in, char* out) {
  out[0] = kBase64Alphabet[in[0] >> 2];
  out[1] = kBase64Alphabet[(in[0] & 3) << 4 | in[1] >> 4];
  out[2] = kBase64Alphabet[(in[1] & 15) << 2 | in[2] >> 6];
  out[3] = kBase64Alphabet[in[2] & 63];
}

}  // namespace

void Base64Writer::write(const void* data, std::size_t size) {
  const auto* in = static_cast<const unsigned char*>(data);
  std::array<char, 4096> text;
  std::size_t used = 0;
  const auto flush = [&] {
    out_.write(text.data(), used);
    used = 0;
  };
  while (size > 0) {
    if (waiting_ == 0 && size >= 3) {
      const std::size_t groups = std::min(size / 3, (text.size() - used) / 4);
      for (std::size_t g = 0; g < groups; ++g, in += 3, used += 4) encode_three(in, text.data() + used);
      size -= 3 * groups;
      if (used == text.size()) flush();
      continue;
    }
    rest_[waiting_++] = *in++;
    --size;
    if (waiting_ < 3) continue;
    encode_three(rest_.data(), text.data() + used);
    waiting_ = 0;
    used += 4;
    if (used == text.size()) flush();
  }
  flush();
}

void Base64Writer::finish() {
  if (waiting_ == 0) return;
  for (std::size_t i = waiting_; i < 3; ++i) rest_[i] = 0;
  std::array<char, 4> text;
  encode_three(rest_.data(), text.data());
  for (std::size_t i = waiting_ + 1; i < 4; ++i) text[i] = '=';
  out_.write(text.data(), text.size());
  waiting_ = 0;
}

std::string encode_base64(std::string_view bytes) {
  std::ostringstream out;
  Base64Writer writer(out);
  writer.write(bytes.data(), bytes.size());
  writer.finish();
  return std::move(out).str();
}

bool decode_base64(std::string_view text, std::string& bytes) {
  static const auto values = base64_values();
  bytes.clear();
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t group = 0;
  int digits = 0, padding = 0;
  for (const char c : text) {
    if (c == '\n' || c == '\r' || c == ' ' || c == '\t') continue;
    if (c == '=' && digits >= 2) {
      if (++padding + digits == 4) break;
      continue;
    }
    const int v = values[static_cast<unsigned char>(c)];
    if (v < 0 || padding > 0) return false;
    group = group << 6 | static_cast<std::uint32_t>(v);
    if (++digits < 4) continue;
    for (int shift = 16; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(group >> shift & 255));
    group = 0;
    digits = 0;
  }
  if (digits == 0) return padding == 0;
  if (digits + padding != 4) return false;
  group <<= 6 * padding;
  for (int i = 0, shift = 16; i < digits - 1; ++i, shift -= 8)
    bytes.push_back(static_cast<char>(group >> shift & 255));
  return true;
}

}  // namespace terrazzo
