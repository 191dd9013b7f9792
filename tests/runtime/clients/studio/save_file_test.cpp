#include "runtime/clients/studio/live/save_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "runtime/files.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using studio::SaveFile;

std::string text_of(const fs::path& file) { return read_file(file).value_or("(none)"); }
void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
bool save(SaveFile& file, const std::string& text) {
  return file.write([&](const fs::path&) { return text; });
}

TEST(SaveFile, SessionsNeverShareAName) {
  const fs::path folder = test::temporary_folder(), name = folder / "a_painted.yaml";
  put(name, "an earlier session's");
  fs::create_symlink(folder / "nowhere", folder / "a_painted_2.yaml");
  SaveFile one = SaveFile::numbered(name), other = SaveFile::numbered(name);
  EXPECT_EQ(one.path(), folder / "a_painted_3.yaml");
  EXPECT_EQ(other.path(), folder / "a_painted_4.yaml");
  EXPECT_FALSE(save(one, "1"));
  EXPECT_FALSE(save(other, "2"));
  EXPECT_FALSE(save(one, "1 again"));
  EXPECT_EQ(text_of(one.path()), "1 again");
  EXPECT_EQ(text_of(other.path()), "2");
  EXPECT_EQ(text_of(name), "an earlier session's");
}

TEST(SaveFile, ReplacesAFileOnlyWhenToldTo) {
  const fs::path name = test::temporary_folder() / "b.yaml";
  put(name, "precious");
  EXPECT_EQ(test::code_of([&] { SaveFile::exactly(name, false); }), "usage");
  EXPECT_EQ(text_of(name), "precious");
  {
    SaveFile file = SaveFile::exactly(name, true);
    EXPECT_EQ(text_of(name), "precious");  // until something is saved
    EXPECT_FALSE(save(file, "new"));
  }
  EXPECT_EQ(text_of(name), "new");
}

TEST(SaveFile, ReplacesWhatALinkRefersTo) {
  const fs::path folder = test::temporary_folder(), link = folder / "link.yaml";
  put(folder / "target.yaml", "precious");
  fs::create_symlink("target.yaml", link);
  SaveFile file = SaveFile::exactly(link, true);
  EXPECT_FALSE(save(file, "new"));
  EXPECT_FALSE(save(file, "newer"));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(text_of(folder / "target.yaml"), "newer");
}

TEST(SaveFile, KeepsWhatSomebodyElseWroteMeanwhile) {
  const fs::path folder = test::temporary_folder(), name = folder / "c.yaml";
  SaveFile file = SaveFile::exactly(name, false);
  EXPECT_FALSE(save(file, "mine"));
  put(name, "theirs");
  EXPECT_TRUE(save(file, "mine again"));
  EXPECT_EQ(text_of(name), "theirs");
  EXPECT_EQ(file.path(), folder / "c_2.yaml");
  EXPECT_EQ(text_of(file.path()), "mine again");
  EXPECT_FALSE(save(file, "and again"));
  EXPECT_EQ(text_of(file.path()), "and again");
  fs::remove(file.path());
  EXPECT_FALSE(save(file, "not lost"));
  EXPECT_EQ(text_of(folder / "c_2.yaml"), "not lost");
  // The file changed between the start and the first save.
  SaveFile old = SaveFile::exactly(name, true);
  put(name, "theirs, later");
  EXPECT_TRUE(save(old, "mine"));
  EXPECT_EQ(text_of(name), "theirs, later");
}

TEST(SaveFile, LeavesNothingWhereNothingWasSaved) {
  const fs::path folder = test::temporary_folder();
  { const SaveFile file = SaveFile::numbered(folder / "d.yaml"); }
  EXPECT_TRUE(fs::is_empty(folder));
  {
    const SaveFile file = SaveFile::numbered(folder / "d.yaml");
    put(file.path(), "theirs");
  }
  EXPECT_EQ(text_of(folder / "d.yaml"), "theirs");
  EXPECT_EQ(test::code_of([&] { SaveFile::numbered(folder / "no folder" / "d.yaml"); }), "write-failed");
}

}  // namespace
}  // namespace terrazzo
