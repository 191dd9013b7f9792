// Files that other users of the machine could have placed are not trusted.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "runtime/cache/cache_folder.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// Without HOME, the cache is in the temporary folder, where anybody could have created it first.
class CacheWithoutHome : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(::chmod(folder.c_str(), 01777), 0);  // like /tmp
    std::ofstream(folder / "g.yaml") << "terrazzo: 1\nnodes: {s: {type: Shape}}\n";
  }
  test::ProgramRun run() {
    return test::run_command({"env", "-u", "HOME", "-u", "XDG_CACHE_HOME", "TMPDIR=" + folder.string(),
                              (test::build_folder() / "terrazzo").string(), "run",
                              (folder / "g.yaml").string(), "--out", (folder / "out").string()});
  }
  static mode_t mode(const fs::path& path) {
    struct stat s = {};
    ::stat(path.c_str(), &s);
    return s.st_mode & 07777;
  }
  fs::path folder = test::temporary_folder(),
           cache = folder / ("terrazzo-cache-" + std::to_string(::getuid()));
};

TEST_F(CacheWithoutHome, IsMadePrivate) {
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_TRUE(is_cache_folder(cache));
  EXPECT_EQ(mode(cache), 0700u);
}

TEST_F(CacheWithoutHome, IsMadePrivateAgain) {
  ASSERT_EQ(run().exit_code, 0);
  ASSERT_EQ(::chmod(cache.c_str(), 0777), 0);
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(mode(cache), 0700u);
}

TEST_F(CacheWithoutHome, OfAnotherUserIsNotUsed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can change the owner of a folder";
  fs::create_directory(cache);
  ASSERT_EQ(::chown(cache.c_str(), 65534, 65534), 0);
  const auto r = run();
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("belongs to another user"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("not kept"), std::string::npos) << r.err;
  EXPECT_TRUE(fs::is_empty(cache));
}

TEST_F(CacheWithoutHome, ALinkToTheUsersFilesIsRefused) {
  fs::create_directory(folder / "documents");
  std::ofstream(folder / "documents" / "thesis.doc") << "mine";
  fs::create_directory_symlink(folder / "documents", cache);
  const auto r = run();
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("not kept"), std::string::npos) << r.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "documents"), {}), 1);
}

TEST(Plugins, ThatOthersMayWriteToAreNotLoaded) {
  const fs::path folder = test::temporary_folder(), plugin = folder / "x.so";
  std::ofstream(plugin) << "no library";
  std::ofstream(folder / "g.yaml") << "terrazzo: 1\nnodes: {s: {type: Shape}}\n";
  const auto says = [&] {
    return test::run_program({"check", (folder / "g.yaml").string()},
                             {.environment = "TERRAZZO_PLUGIN_PATH=" + folder.string()})
        .err;
  };
  EXPECT_EQ(says().find("may write"), std::string::npos)
      << says();  // it fails to load because of its content
  ::chmod(plugin.c_str(), 0666);
  EXPECT_NE(says().find("is not loaded: everybody may write to"), std::string::npos) << says();
  ::chmod(plugin.c_str(), 0644), ::chmod(folder.c_str(), 0777);
  EXPECT_NE(says().find("is not loaded: everybody may write to"), std::string::npos) << says();
}

}  // namespace
}  // namespace terrazzo
