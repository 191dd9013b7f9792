#include "runtime/value_file.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace terrazzo {
namespace {

constexpr char magic[8] = {'T', 'Z', 'V', 'A', 'L', '0', '0', '2'};

std::optional<double> seconds_of(const char* head) {
  std::uint64_t sum;
  double seconds;
  std::memcpy(&seconds, head + 8, 8), std::memcpy(&sum, head + 16, 8);
  if (std::memcmp(head, magic, 8) != 0 || sum != hash_of(head, 16).low || !std::isfinite(seconds)) return {};
  return seconds;
}

}  // namespace

std::string value_head(double seconds) {
  std::string head(magic, sizeof magic);
  head.append(reinterpret_cast<const char*>(&seconds), 8);
  const std::uint64_t sum = hash_of(head).low;
  return head.append(reinterpret_cast<const char*>(&sum), 8);
}

std::string_view value_payload(const std::string& text, const Hash& content) {
  if (text.size() <= value_head_size || !seconds_of(text.data()) ||
      hash_of(text.data() + value_head_size, text.size() - value_head_size) != content)
    return {};
  return std::string_view(text).substr(value_head_size);
}

std::optional<ValueSummary> value_summary(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  char head[value_head_size + 8];
  if (!in.read(head, sizeof head)) return {};
  const auto seconds = seconds_of(head);
  std::uint64_t length;
  std::memcpy(&length, head + value_head_size, sizeof length);
  if (!seconds || length > 64) return {};
  ValueSummary out{*seconds, std::string(length, '\0')};
  if (!in.read(out.type.data(), static_cast<std::streamsize>(length))) return {};
  return out;
}

}  // namespace terrazzo
