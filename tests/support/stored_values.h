// Helpers of the tests of readers of values.
#pragma once

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

}  // namespace terrazzo::test
