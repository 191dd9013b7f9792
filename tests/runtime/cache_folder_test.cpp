// The cache folder: only marked folders are used, and only files that this program named are removed.
#include "runtime/cache/cache_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "nodes/data/table.h"
#include "runtime/cache/disk_cache.h"
#include "runtime/cache/store.h"
#include "runtime/cache/value_file.h"
#include "runtime/files.h"
#include "runtime/trust.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::code_of;

class CacheFolder : public ::testing::Test {
 protected:
  static void write(const fs::path& file, const std::string& text = "mine") {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  // Sets a file's time to `days` ago; negative: in the future.
  static void age(const fs::path& file, double days = 365) {
    struct timespec now;
    ::clock_gettime(CLOCK_REALTIME, &now);
    const struct timespec then = {now.tv_sec - static_cast<time_t>(86400 * days), 0}, times[2] = {then, then};
    ASSERT_EQ(::utimensat(AT_FDCWD, file.c_str(), times, 0), 0);
  }
  std::string code(const fs::path& folder) {
    return code_of([&] { open_cache_folder(folder); });
  }
  fs::path folder = test::temporary_folder(), cache = folder / "cache";
};

TEST_F(CacheFolder, IsMadePrivateAndMarked) {
  EXPECT_FALSE(is_cache_folder(cache));
  open_cache_folder(cache);
  EXPECT_TRUE(is_cache_folder(cache));
  EXPECT_TRUE(read_file(cache / "CACHEDIR.TAG")->starts_with("Signature: 8a477f597d28d172789f06886806bc55"));
  struct stat s;
  ASSERT_EQ(::stat(cache.c_str(), &s), 0);
  EXPECT_EQ(s.st_mode & 0777, 0700u);
  open_cache_folder(cache);  // again
  EXPECT_TRUE(is_cache_folder(cache));
}

TEST_F(CacheFolder, AFolderOfTheUsersIsRefusedAndLeftAlone) {
  for (const char* file :
       {"thesis.doc", "files/thesis.doc", "values/ab/notes", "actions/deep/er/x", ".hidden"}) {
    const fs::path project = folder / "project";
    fs::remove_all(project);
    write(project / file);
    EXPECT_EQ(code(project), "not-a-cache") << file;
    EXPECT_EQ(read_file(project / file), "mine");
    EXPECT_FALSE(fs::exists(project / "CACHEDIR.TAG"));
    // A store in this folder keeps results in memory and reports the problem.
    Store store(test::value_types(), project);
    EXPECT_FALSE(store.trouble().empty());
    EXPECT_FALSE(store.keeps_on_disk());
    store.put_value(Value::of(Table{{"a"}, {{1.0}}}));
    EXPECT_FALSE(fs::exists(project / "values" / "incoming"));
    EXPECT_EQ(read_file(project / file), "mine");
  }
}

TEST_F(CacheFolder, OfAnotherVersionIsRefused) {
  open_cache_folder(cache);
  for (const char* mark : {"99\n", "1", "\x31\x8a", ""}) {  // or damaged
    write(cache / "terrazzo-cache", mark);
    EXPECT_EQ(code(cache), "cache-unusable") << mark;
    EXPECT_EQ(code_of([&] { require_cache_folder(cache); }), "usage");
    Store store(test::value_types(), cache);
    EXPECT_NE(store.trouble().find("its mark 'terrazzo-cache'"), std::string::npos) << store.trouble();
    EXPECT_FALSE(store.keeps_on_disk());
  }
}

TEST_F(CacheFolder, ThatCannotBeListedIsUnusable) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may list every folder";
  fs::create_directories(cache);
  ASSERT_EQ(::chmod(cache.c_str(), 0300), 0);
  EXPECT_EQ(code(cache), "cache-unusable");
  ASSERT_EQ(::chmod(cache.c_str(), 0700), 0);
}

TEST_F(CacheFolder, OfAVersionWithoutMarksIsTakenOver) {
  const std::string name = hash_of("x").text();
  write(cache / "actions" / name.substr(0, 2) / name);
  write(cache / "files" / name);
  write(cache / "lock");
  write(cache / "values" / ".incoming-12-3.12.4.tmp");
  EXPECT_EQ(code(cache), "");
  EXPECT_TRUE(is_cache_folder(cache));
}

TEST_F(CacheFolder, ThatSomebodyIsJustMarkingIsJoined) {
  write(cache / "usage", "");
  write(cache / ".CACHEDIR.host.1.0123456789abcdef.tmp.TAG", "");
  write(cache / ".terrazzo-cache.host.1.0123456789abcdef.tmp", "");
  EXPECT_EQ(code(cache), "");
  EXPECT_TRUE(is_cache_folder(cache));
}

TEST_F(CacheFolder, ThatEverybodyMayWriteToIsRefused) {
  fs::create_directories(cache);
  ASSERT_EQ(::chmod(cache.c_str(), 0777), 0);
  EXPECT_EQ(code(cache), "unsafe-folder");
}

// Files that the user put into a cache folder later, old enough to be collected.
TEST_F(CacheFolder, CollectingSweepingAndClearingRemoveOnlyOurOwn) {
  open_cache_folder(cache);
  const std::string name = hash_of("x").text();
  const std::vector<fs::path> theirs = {"files/thesis.doc",          "history/.git/HEAD",
                                        "values/ab/photo.png",       "values/" + std::string(31, 'a'),
                                        "actions/" + name + ".txt",  "actions/zz/" + name,
                                        "values/00/" + name,  // in the wrong part
                                        "files/.photo.host.1.x.tmp", "notes.txt"};
  for (const auto& f : theirs) {
    write(cache / f);
    age(cache / f);
  }
  const fs::path ours = cache_entry(cache, "files", hash_of("y"));
  write(ours);
  age(ours);
  write(cache / "values" / ".incoming.host.12.0123456789abcdef.tmp");
  age(cache / "values" / ".incoming.host.12.0123456789abcdef.tmp");
  for (int i = 0; i < 256; ++i) tend_cache(cache, 1'000'000'000);
  EXPECT_FALSE(fs::exists(ours));
  EXPECT_FALSE(fs::exists(cache / "values" / ".incoming.host.12.0123456789abcdef.tmp"));
  collect_cache(cache, 0);
  clear_cache(cache);
  for (const auto& f : theirs) EXPECT_EQ(read_file(cache / f), "mine") << f;
  EXPECT_TRUE(is_cache_folder(cache));
}

TEST_F(CacheFolder, LinksInItAreNotFollowed) {
  open_cache_folder(cache);
  const std::string name = hash_of("x").text();
  const fs::path elsewhere = folder / "elsewhere" / name;
  write(elsewhere);
  age(elsewhere);
  fs::create_directories(cache / "files" / name.substr(0, 2));
  fs::create_symlink(elsewhere, cache / "files" / name.substr(0, 2) / name);
  collect_cache(cache, 0);
  clear_cache(cache);
  EXPECT_EQ(read_file(elsewhere), "mine");
}

TEST_F(CacheFolder, RecordsCountTowardTheLimit) {
  {
    Store store(test::value_types(), cache);
    for (int i = 0; i < 200; ++i) {
      auto r = std::make_shared<ActionRecord>();
      r->type = "Constant";
      store.put_action(hash_of(std::to_string(i)), r);
      age(cache_entry(cache, "actions", hash_of(std::to_string(i))), (200 - i) / 24.0);
    }
  }
  EXPECT_EQ(cache_stats(cache).bytes(), 200u * 4096);
  const Collected c = tend_cache(cache, 100 * 4096);
  EXPECT_EQ(c.records, 110u);
  EXPECT_EQ(cache_stats(cache).bytes(), 90u * 4096);
  // The most recently used records stay.
  Store store(test::value_types(), cache);
  Tier tier;
  EXPECT_TRUE(store.find_action(hash_of("110"), tier));
  EXPECT_FALSE(store.find_action(hash_of("109"), tier));
}

TEST_F(CacheFolder, AFullOneIsRelievedPartByPart) {
  {
    Store store(test::value_types(), cache);
    for (int i = 0; i < 30'000; ++i) {  // more than 100 per part
      const fs::path f = cache_entry(cache, "values", hash_of(std::to_string(i)));
      write(f, value_head(i % 2 == 0 ? 1 : 1000) + std::string(16, '\0'));
    }
    CacheUsage(cache).add(30'000 * 4096);
  }
  const std::uint64_t limit = 29'000ull * 4096;
  const Collected c = tend_cache(cache, limit);
  EXPECT_GT(c.values, 1000u);
  EXPECT_LT(c.values, 3000u);  // not all parts were reduced by a tenth
  EXPECT_LE(cache_stats(cache).bytes(), limit);
  EXPECT_EQ(CacheUsage(cache).add(0), cache_stats(cache).bytes());
  // Only cheap values were removed.
  std::uint64_t cheap = 0, dear = 0;
  each_cache_file(cache, "values", -1,
                  [&](const CacheFile& f) { ++(value_summary(f.path)->seconds < 2 ? cheap : dear); });
  EXPECT_EQ(dear, 15'000u);
  EXPECT_EQ(cheap, 15'000u - c.values);
}

TEST_F(CacheFolder, WithinItsLimitOnePartIsLookedAtNotAll) {
  open_cache_folder(cache);
  // Old, unreadable records: each call removes those of one part.
  for (int i = 0; i < 600; ++i) {
    const fs::path f = cache_entry(cache, "actions", hash_of(std::to_string(i)));
    write(f);
    age(f);
  }
  const Collected first = tend_cache(cache, 1'000'000'000);
  EXPECT_LT(first.records, 20u);
  std::uint64_t all = first.records;
  for (int i = 1; i < 256; ++i) all += tend_cache(cache, 1'000'000'000).records;
  EXPECT_EQ(all, 600u);
}

TEST_F(CacheFolder, TheSumOfBytesNeverFallsBelowZero) {
  open_cache_folder(cache);
  const CacheUsage usage(cache);
  EXPECT_EQ(usage.add(5000), 5000u);
  EXPECT_EQ(usage.add(-8000), 0u);
  EXPECT_EQ(usage.add(100), 100u);
  fs::remove(cache / "usage");
  EXPECT_EQ(usage.add(100), std::numeric_limits<std::uint64_t>::max());  // unknown
}

TEST_F(CacheFolder, ATimeInTheFutureIsNotLeastValuable) {
  OutputRecord future, past;
  {
    Store store(test::value_types(), cache);
    const auto put = [&](double v) {
      return store.put_value(Value::of(Table{{"a"}, std::vector<std::vector<Table::Cell>>(4000, {v})}), 1);
    };
    future = put(1);
    past = put(2);
  }
  age(cache_entry(cache, "values", future.content), -2);
  age(cache_entry(cache, "values", past.content), 2);
  EXPECT_EQ(collect_cache(cache, cache_stats(cache).bytes() - 1).values, 1u);
  Store store(test::value_types(), cache);
  EXPECT_TRUE(store.has_value(future));
  EXPECT_FALSE(store.has_value(past));
}

TEST(WhoElseMayWrite, SeesModesOfThePathAndOfTheFoldersAboveIt) {
  const fs::path folder = test::temporary_folder(), file = folder / "inner" / "x.so";
  fs::create_directories(file.parent_path());
  std::ofstream(file) << "x";
  EXPECT_EQ(who_else_may_write(file), "");
  EXPECT_EQ(who_else_may_write(folder / "not" / "there"), "");
  ::chmod(file.c_str(), 0666);
  EXPECT_NE(who_else_may_write(file), "");
  ::chmod(file.c_str(), 0644), ::chmod(file.parent_path().c_str(), 0777);
  EXPECT_NE(who_else_may_write(file), "");
  ::chmod(file.parent_path().c_str(), 01777);  // as /tmp
  EXPECT_EQ(who_else_may_write(file), "");
  EXPECT_NE(who_else_may_write(file.parent_path()), "");
  ::chmod(file.parent_path().c_str(), 0755), ::chmod(folder.c_str(), 0777);
  EXPECT_NE(who_else_may_write(file), "");
  ::chmod(folder.c_str(), 0755);
  fs::create_symlink(file, folder / "link.so");
  ::chmod(file.c_str(), 0666);
  EXPECT_NE(who_else_may_write(folder / "link.so"), "");
}

TEST(WhoElseMayWrite, SeesAnotherOwner) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  const fs::path file = test::temporary_folder() / "x.so";
  std::ofstream(file) << "x";
  ASSERT_EQ(::chown(file.c_str(), 65534, 65534), 0);
  EXPECT_NE(who_else_may_write(file).find("another user"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
