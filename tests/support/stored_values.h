// Helpers of the tests of readers of values.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/codec.h"
#include "runtime/value.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

// The bytes that decide the content hash.
template <class T>
std::vector<char> bytes_of(const T& v) {
  BufferWriter w;
  value_type<T>().encode(&v, w);
  return w.buffer;
}

// The path of a .json file that Export wrote from the value.
template <class T>
std::string exported_json(const T& v) {
  const auto folder = temporary_folder();
  run_node("Export", {{"value", Value::of(v)}}, {{"path", "a.json"}}, folder);
  return (folder / "a.json").string();
}

// The text with the first `from` replaced by `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " is not in " << text;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace terrazzo::test
