// Texts that differ from a known one in a passage.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace terrazzo::test {

// The text with the first `from` replaced by `to`. Fails if there is none.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " is not in " << text;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace terrazzo::test
