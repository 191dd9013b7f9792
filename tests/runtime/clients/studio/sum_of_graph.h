// What a graph of arithmetic nodes computes.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "graph/diagnostic.h"
#include "runtime/session.h"
#include "tests/support/arithmetic.h"

namespace terrazzo::test {

// The value of sum.out in a graph whose text would stand in `file`; fails if the graph has errors.
inline double sum_of_graph(const std::string& text, const std::filesystem::path& file) {
  Session session(arithmetic(), value_types());
  const Diagnostics found = session.open_text(text, file);
  EXPECT_TRUE(found.empty()) << found.front().text() << text;
  return found.empty() ? number_of(session.value("sum.out")) : 0;
}

}  // namespace terrazzo::test
