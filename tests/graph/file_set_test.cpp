// Paths that name one file.
#include "graph/document/file_set.h"

#include <gtest/gtest.h>

#include <fstream>

#include "graph/text/read_number.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(FileSet, KnowsAFileByAnyPath) {
  const fs::path folder = test::temporary_folder(), file = folder / "in" / "photo.png";
  fs::create_directories(folder / "in" / "deep");
  std::ofstream(file) << "x";
  std::ofstream(folder / "other.png") << "x";
  fs::create_symlink(file, folder / "link.png");
  fs::create_symlink("link.png", folder / "link of a link.png");
  fs::create_hard_link(file, folder / "second name.png");
  fs::create_directory_symlink(folder / "in" / "deep", folder / "way");
  FileSet set;
  set.add(file);
  for (const char* path : {"in/photo.png", "in/./photo.png", "in/deep/../photo.png", "./in//photo.png",
                           "link.png", "link of a link.png", "second name.png", "way/../photo.png"}) {
    ASSERT_NE(set.find(folder / path), nullptr) << path;
    EXPECT_EQ(*set.find(folder / path), file) << path;
  }
  for (const char* path : {"other.png", "photo.png", "in/none.png", "in", "in/deep/photo.png"})
    EXPECT_EQ(set.find(folder / path), nullptr) << path;
}

TEST(FileSet, AFileThatIsMissingHasAPlace) {
  const fs::path folder = test::temporary_folder();
  fs::create_directories(folder / "in");
  fs::create_directory_symlink("in", folder / "way");
  fs::create_symlink("nowhere", folder / "link.png");
  FileSet set;
  set.add(folder / "in" / "new.png");
  set.add(folder / "link.png");
  EXPECT_NE(set.find(folder / "way" / "new.png"), nullptr);
  EXPECT_NE(set.find(folder / "way" / ".." / "in" / "new.png"), nullptr);
  EXPECT_NE(set.find(folder / "in" / ".." / "link.png"), nullptr);
  EXPECT_EQ(set.find(folder / "new.png"), nullptr);
  EXPECT_EQ(set.find(folder / "nowhere"), nullptr);
}

TEST(NumberText, IsTheWholeTextInAnyLocale) {
  EXPECT_EQ(number_in_text<double>("0.5"), 0.5);
  EXPECT_EQ(number_in_text<double>("-1e-3"), -1e-3);
  EXPECT_EQ(number_in_text<int>("007"), 7);
  for (const char* bad : {"", "0,5", "1 ", " 1", "1x", "x"}) EXPECT_FALSE(number_in_text<double>(bad)) << bad;
  EXPECT_FALSE(number_in_text<unsigned>("-1"));
  EXPECT_FALSE(number_in_text<std::uint8_t>("256"));
  std::string_view text = "  12 3.5x";
  EXPECT_EQ(take_number<int>(text), 12);
  EXPECT_EQ(take_number<double>(text), 3.5);
  EXPECT_FALSE(take_number<int>(text));
  EXPECT_EQ(text, "x");
}

}  // namespace
}  // namespace terrazzo
