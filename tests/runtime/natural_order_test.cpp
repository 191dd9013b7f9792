#include "runtime/files/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(NaturalOrder, NumbersCountAsNumbers) {
  std::vector<std::string> names = {"a10",
                                    "a2",
                                    "a1",
                                    "b",
                                    "a",
                                    "a02",
                                    "a2b10",
                                    "a2b9",
                                    "a002",
                                    "10",
                                    "9",
                                    "",
                                    "a-3",
                                    "slice_100000000000000000000000000000000001",
                                    "slice_99999999999999999999999999999999999"};
  std::ranges::sort(names, natural_less);
  const std::vector<std::string> expected = {"",
                                             "9",
                                             "10",
                                             "a",
                                             "a-3",
                                             "a1",
                                             "a002",
                                             "a02",
                                             "a2",
                                             "a2b9",
                                             "a2b10",
                                             "a10",
                                             "b",
                                             "slice_99999999999999999999999999999999999",
                                             "slice_100000000000000000000000000000000001"};
  EXPECT_EQ(names, expected);
}

TEST(NaturalOrder, IsATotalOrder) {
  std::vector<std::string> names;
  for (std::uint64_t k = 0; k < 60; ++k) {
    Random r(1, 1, k);
    std::string name;
    for (int i = static_cast<int>(r.below(5)); i >= 0; --i) name += "01a9-\xc3"[r.below(6)];
    names.push_back(name);
  }
  for (const auto& a : names)
    for (const auto& b : names) {
      ASSERT_EQ(natural_less(a, b) + natural_less(b, a), a != b) << a << ' ' << b;
      for (const auto& c : names)
        if (natural_less(a, b) && natural_less(b, c))
          ASSERT_TRUE(natural_less(a, c)) << a << ' ' << b << ' ' << c;
    }
}

TEST(NaturalOrder, GlobsFollowIt) {
  const auto folder = test::temporary_folder();
  for (const int part : {10, 9})
    for (const int k : {1, 10, 11, 2}) {
      const auto place = folder / ("part" + std::to_string(part));
      std::filesystem::create_directories(place);
      std::ofstream(place / ("s" + std::to_string(k) + ".png")) << "x";
    }
  std::vector<std::string> found;
  for (const auto& path : expand_glob(folder / "part*" / "s*.png"))
    found.push_back(path.lexically_relative(folder).string());
  const std::vector<std::string> expected = {"part9/s1.png",   "part9/s2.png",  "part9/s10.png",
                                             "part9/s11.png",  "part10/s1.png", "part10/s2.png",
                                             "part10/s10.png", "part10/s11.png"};
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace terrazzo
