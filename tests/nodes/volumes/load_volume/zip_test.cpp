// Stacks of pictures in zip archives.
#include <gtest/gtest.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/zip.h"
#include "runtime/files.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/tiff_file.h"
#include "tests/support/zip_file.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// Pictures of two pixels, one for each page.
std::string pages_of_pairs(std::initializer_list<int> firsts) {
  std::vector<test::TiffPage> pages;
  for (const int first : firsts) {
    test::TiffPage page{2, 1};
    page.pixels = {static_cast<char>(first), static_cast<char>(first + 100)};
    pages.push_back(page);
  }
  return test::tiff_file(pages);
}

class Zip : public ::testing::Test {
 protected:
  using Entries = std::vector<std::pair<std::string, std::string>>;
  // The first number of each slice.
  std::vector<float> firsts(const Entries& entries, const std::string& entry = "") {
    const auto scan = load_volume::read_zip(test::write_zip(path, entries), entry);
    std::vector<float> out;
    for (int z = 0; z < scan.size.z(); ++z) out.push_back(scan.stored(2 * z));
    EXPECT_EQ(scan.size, Vec3i(2, 1, scan.size.z()));
    return out;
  }
  Diagnostic refused(const std::string& entry = "", std::uint64_t memory = 1'000'000'000) {
    Reading reading;
    reading.memory = memory;
    try {
      load_volume::read_zip(path, entry, {}, {}, reading);
    } catch (const Error& e) {
      return e.diagnostic();
    }
    return {};
  }
  fs::path path = test::temporary_folder() / "a.zip";
};

using Firsts = std::vector<float>;

TEST_F(Zip, HoldsOnePictureWithPages) {
  EXPECT_EQ(firsts({{"rock/", ""}, {"rock/rock.tif", pages_of_pairs({3, 4, 5})}, {"readme.txt", "words"}}),
            (Firsts{3, 4, 5}));
}

TEST_F(Zip, HoldsASliceInEachFile) {
  const Entries slices = {{"rock/s10.tif", pages_of_pairs({10})},
                          {"rock/s9.tif", pages_of_pairs({9})},
                          {"__MACOSX/rock/._s9.tif", std::string("\0\5\x16\7", 4)},
                          {"rock/s8.tif", pages_of_pairs({8})}};
  EXPECT_EQ(firsts(slices), (Firsts{8, 9, 10}));
  const auto run = test::load_volume(path, {{"spacing", "1"}, {"grid", "id"}});
  EXPECT_EQ(run.output<Volume>("volume").extent, Vec3i(2, 1, 3));
}

TEST_F(Zip, OneNumberOfANameCountsTheSlices) {
  EXPECT_EQ(firsts({{"2um_1_07h.tif", pages_of_pairs({1})},
                    {"2um_2_07h.tif", pages_of_pairs({2})},
                    {"2um_3_08h.tif", pages_of_pairs({3})}}),
            (Firsts{1, 2, 3}));
}

TEST_F(Zip, NamesItsVolumes) {
  const Entries two = {{"x/rock1_1.tif", pages_of_pairs({1})},
                       {"x/rock1_2.tif", pages_of_pairs({2})},
                       {"x/rock2_1.tif", pages_of_pairs({3})},
                       {"x/rock2_2.tif", pages_of_pairs({4})},
                       {"y.tif", pages_of_pairs({5})}};
  test::write_zip(path, two);
  const Diagnostic error = refused();
  EXPECT_EQ(error.code, "several-files");
  EXPECT_EQ(error.parameter, "entry");
  EXPECT_NE(error.message.find("3 volumes: x/rock1_*.tif, x/rock2_*.tif, y.tif"), std::string::npos)
      << error.message;
  EXPECT_EQ(firsts(two, "x/rock2_*.tif"), (Firsts{3, 4}));
  EXPECT_EQ(firsts(two, "y.tif"), (Firsts{5}));
  EXPECT_EQ(refused("z*").parameter, "entry");
  test::write_zip(path, {{"rock1.tif", pages_of_pairs({1, 2})}, {"rock2.tif", pages_of_pairs({3, 4})}});
  EXPECT_NE(refused().message.find("2 volumes: rock1.tif, rock2.tif"), std::string::npos);
}

TEST_F(Zip, RefusesWhatItCannotRead) {
  test::write_zip(path, {{"a.tif", pages_of_pairs({1})}}, "secret");
  EXPECT_NE(refused().message.find("encrypted"), std::string::npos);
  test::write_zip(path, {{"a.npy", "an array"}});
  EXPECT_NE(refused().message.find("no pictures, but a.npy"), std::string::npos);
  test::write_zip(path, {{"a.tif", "II*" + std::string(1 << 26, '\0')}});  // 64 MB in 64 kB
  EXPECT_LT(fs::file_size(path), 100'000u);
  EXPECT_EQ(refused("", 1 << 25).code, "too-large");
  EXPECT_EQ(refused().code, "unreadable-image");
}

TEST_F(Zip, DamageIsAnError) {
  test::write_zip(path, {{"a.tif", pages_of_pairs({1, 2, 3})}});
  const std::string good = *read_file(path);
  int found = 0;
  for (std::size_t at = 4; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(~bad[at]);
    std::ofstream(path, std::ios::binary) << bad;
    const std::string code = refused().code;
    EXPECT_TRUE(code.empty() || code == "unreadable-volume" || code == "too-large") << at << ": " << code;
    found += !code.empty();
  }
  EXPECT_GT(found, static_cast<int>(good.size()) / 2) << "the rest are times and attributes";
  for (std::size_t length = 4; length < good.size(); length += 7) {
    std::ofstream(path, std::ios::binary) << good.substr(0, length);
    EXPECT_EQ(refused().code, "unreadable-volume") << length;
  }
}

}  // namespace
}  // namespace terrazzo
