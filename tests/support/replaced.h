// Expected texts that differ from a known one in a passage.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace terrazzo::test {

// The text with the first `from` replaced by `to`. Fails if there is none.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace terrazzo::test
