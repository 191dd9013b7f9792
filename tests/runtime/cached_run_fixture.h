// Runs that share only a cache folder, like processes one after the other.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/evaluate.h"
#include "runtime/report/explain.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

class CachedRunTest : public ::testing::Test {
 protected:
  using Paths = std::vector<std::string>;

  RunResult run(const Graph& g, RunOptions o = {}) {
    Store store(value_types(), cache);
    FileHashes hashes(cache);
    Evaluator e(value_types(), store, hashes);
    o.output_folder = folder / "out";
    RunResult r = e.run(g, o);
    History(cache).record(g, r, hashes);
    return r;
  }
  const std::filesystem::path folder = temporary_folder();
  std::filesystem::path cache = folder / "cache";
};

}  // namespace terrazzo::test
