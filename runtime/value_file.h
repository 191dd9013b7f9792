// A value's file in the cache: a head of 24 bytes, then the type's name and the encoded value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/hash.h"

namespace terrazzo {

inline constexpr std::size_t value_head_size = 24;

// Magic bytes, the seconds that computing the value took, and a checksum of the two. What a value saves
// stands in its own file, so that collecting need not look for the record that made it.
std::string value_head(double seconds);

// The encoded value in a value file's content (type name first). Empty if it is damaged, foreign or not
// `content`.
std::string_view value_payload(const std::string& text, const Hash& content);

// What a value file says without reading it whole. Nothing if it is damaged or foreign.
struct ValueSummary {
  double seconds = 0;
  std::string type;
};
std::optional<ValueSummary> value_summary(const std::filesystem::path&);

}  // namespace terrazzo
