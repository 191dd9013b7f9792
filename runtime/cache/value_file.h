// The file format of cached values: a header of 24 bytes, then the type name and the encoded value.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/hash.h"

namespace terrazzo {

inline constexpr std::size_t kValueHeadSize = 24;

// The header: magic bytes, the computing time in seconds, and a checksum of both. The time is stored here so
// that collecting does not have to find the value's record.
std::string value_head(double seconds);

// The type name and encoded value in the content of a value file. Empty if the file is damaged, is not a
// value file, or its hash is not `content`.
std::string_view value_payload(const std::string& text, const Hash& content);

// Whether a value file is undamaged and its hash is `content`. Reads it in parts, so it may be larger than
// the memory. Calls `check` between them, which may throw to stop.
bool is_value_of(const std::filesystem::path&, const Hash& content, const std::function<void()>& check);

// Computing time and type of a value file, without reading all of it. Nothing if it is damaged or not a value
// file.
struct ValueSummary {
  double seconds = 0;
  std::string type;
};
std::optional<ValueSummary> value_summary(const std::filesystem::path&);

}  // namespace terrazzo
