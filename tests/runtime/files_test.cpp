// Atomic writing of files.
#include "runtime/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <set>

#include "graph/diagnostic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(WriteAtomically, LeavesTheOldFileAndNothingElseOnFailure) {
  const fs::path folder = test::temporary_folder(), file = folder / "x.txt";
  write_text_atomically(file, "old");
  EXPECT_EQ(test::code_of([&] {
              write_atomically(file, [](const fs::path& temporary) {
                std::ofstream(temporary) << "half";
                throw Error("broken", "the writer gave up");
              });
            }),
            "broken");
  EXPECT_EQ(read_file(file), "old");
  EXPECT_EQ(files_in(folder), 1u);
  write_text_atomically(file, "new");
  EXPECT_EQ(read_file(file), "new");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST(WriteAtomically, KeepsTheExtensionForWritersThatChooseByIt) {
  const fs::path file = test::temporary_folder() / "deep" / "x.png";
  write_atomically(file, [](const fs::path& temporary) {
    EXPECT_EQ(temporary.extension(), ".png");
    EXPECT_EQ(temporary.filename().string()[0], '.');
    EXPECT_TRUE(fs::exists(temporary))
        << "must exist before the writer opens it, so that nobody else can create it";
    std::ofstream(temporary) << "x";
  });
  EXPECT_EQ(read_file(file), "x");
}

TEST(WriteAtomically, NamesTheReasonAndTheFile) {
  const fs::path folder = test::temporary_folder();
  std::ofstream(folder / "file") << "no folder";
  try {
    write_text_atomically(folder / "file" / "x", "text");
    FAIL() << "a file cannot hold files";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "write-failed");
    EXPECT_NE(e.diagnostic().message.find((folder / "file" / "x").string()), std::string::npos) << e.what();
  }
}

TEST(WriteAtomically, ReplacesNoDevicesAndPipes) {
  const fs::path pipe = test::temporary_folder() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(test::code_of([&] { write_text_atomically(pipe, "text"); }), "write-failed");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(files_in(pipe.parent_path()), 1u);
}

// A forked process shares the state of any random generator in memory, so names must not depend on one.
TEST(TemporaryFile, NoTwoProcessesShareAName) {
  const fs::path folder = test::temporary_folder();
  std::set<std::string> names;
  for (int i = 0; i < 2000; ++i) names.insert(TemporaryFile(folder, "x").path().filename().string());
  EXPECT_EQ(names.size(), 2000u);
  const pid_t child = ::fork();
  if (child == 0) {
    bool fresh = true;
    for (int i = 0; i < 2000; ++i)
      fresh = fresh && !names.count(TemporaryFile(folder, "x").path().filename().string());
    ::_exit(fresh ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  for (const auto& n : names) EXPECT_TRUE(is_temporary_name(n, "x")) << n;
  EXPECT_EQ(files_in(folder), 0u);
}

TEST(TemporaryFile, NamesOfOtherProgramsAreNotTakenForOurs) {
  for (const char* name : {"x.host.1.0123456789abcdef.tmp", ".y.host.1.0123456789abcdef.tmp", ".x.swp",
                           ".x.tmp", ".x.host.pid.0123456789abcdef.tmp", ".x.host.1.0123456789ABCDEF.tmp",
                           ".x.host.1.0123456789abcdef.tmp.bak", ".x.host.1.012345.tmp", "x"})
    EXPECT_FALSE(is_temporary_name(name, "x")) << name;
  EXPECT_TRUE(is_temporary_name(".x.host.1.0123456789abcdef.tmp", "x"));
}

}  // namespace
}  // namespace terrazzo
