#include "runtime/cache/value_file.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "graph/input_file.h"

namespace terrazzo {
namespace {

constexpr char kMagic[8] = {'T', 'Z', 'V', 'A', 'L', '0', '0', '2'};

std::optional<double> seconds_of(const char* head) {
  std::uint64_t sum;
  double seconds;
  std::memcpy(&seconds, head + 8, 8);
  std::memcpy(&sum, head + 16, 8);
  if (std::memcmp(head, kMagic, 8) != 0 || sum != hash_of(head, 16).low || !std::isfinite(seconds)) return {};
  return seconds;
}

}  // namespace

std::string value_head(double seconds) {
  std::string head(kMagic, sizeof kMagic);
  head.append(reinterpret_cast<const char*>(&seconds), 8);
  const std::uint64_t sum = hash_of(head).low;
  return head.append(reinterpret_cast<const char*>(&sum), 8);
}

std::string_view value_payload(const std::string& text, const Hash& content) {
  if (text.size() <= kValueHeadSize || !seconds_of(text.data()) ||
      hash_of(text.data() + kValueHeadSize, text.size() - kValueHeadSize) != content)
    return {};
  return std::string_view(text).substr(kValueHeadSize);
}

bool is_value_of(const std::filesystem::path& path, const Hash& content, const std::function<void()>& check) {
  InputFile file(path);
  std::vector<char> part(1 << 20);
  if (!file || file.read(part.data(), kValueHeadSize) < kValueHeadSize || !seconds_of(part.data()))
    return false;
  HashWriter writer;
  while (const std::size_t n = file.read(part.data(), part.size())) {
    writer.bytes(part.data(), n);
    check();
  }
  return file.trouble().empty() && writer.size() > 0 && writer.hash() == content;
}

std::optional<ValueSummary> value_summary(const std::filesystem::path& path) {
  constexpr std::size_t kLongest = 64;  // name of a type
  const std::string head = read_beginning(path, kValueHeadSize + 8 + kLongest);
  if (head.size() < kValueHeadSize + 8) return {};
  const auto seconds = seconds_of(head.data());
  std::uint64_t length;
  std::memcpy(&length, head.data() + kValueHeadSize, sizeof length);
  if (!seconds || length > kLongest || head.size() < kValueHeadSize + 8 + length) return {};
  return ValueSummary{*seconds, head.substr(kValueHeadSize + 8, length)};
}

}  // namespace terrazzo
