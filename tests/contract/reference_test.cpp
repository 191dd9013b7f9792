// Checks that the generated node reference matches the declarations.
#include <gtest/gtest.h>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(Reference, IsFresh) {
  const fs::path fresh = test::temporary_folder(), kept = test::source_folder() / "docs" / "nodes";
  const auto run = test::run_program({"nodes", "--markdown", "--out", fresh.string(), "--examples",
                                      (test::source_folder() / "nodes").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const auto& e : fs::directory_iterator(fresh)) {
    const std::string name = e.path().filename().string();
    EXPECT_EQ(read_file(kept / name).value_or(""), read_file(e.path()).value_or("?"))
        << name << ": run ./dev docs";
    const auto page = *read_file(e.path());
    if (const auto at = page.find("](images/"); at != std::string::npos) {
      const std::string picture = page.substr(at + 2, page.find(')', at) - at - 2);
      EXPECT_TRUE(fs::exists(kept / picture)) << picture << ": run ./dev docs";
    }
  }
  for (const auto& e : fs::directory_iterator(kept))
    if (e.path().extension() == ".md") {
      EXPECT_TRUE(fs::exists(fresh / e.path().filename())) << e.path() << " belongs to no node type";
    }
}

}  // namespace
}  // namespace terrazzo
