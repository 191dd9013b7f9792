// Every C++ source is formatted as ./dev format does it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace terrazzo {
namespace {

TEST(Sources, AreFormatted) {
  if (std::system("clang-format --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no clang-format";
  const std::string command =
      std::string("cd '") + TERRAZZO_SOURCE +
      "' && find graph runtime nodes tests -name '*.cpp' -print0 -o -name '*.h' -print0 | "
      "xargs -0 clang-format --dry-run -Werror";
  EXPECT_EQ(std::system(command.c_str()), 0) << "run ./dev format";
}

}  // namespace
}  // namespace terrazzo
