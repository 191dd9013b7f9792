// Files as inputs: the content that was read decides, whatever the file's name, size and times are.
#include "runtime/cache/file_hashes.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <thread>
#include <utility>

#include "nodes/data/table.h"
#include "runtime/cache/store.h"
#include "runtime/context.h"
#include "runtime/evaluate.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class FileHashesTest : public ::testing::Test {
 protected:
  void SetUp() override { Store(test::value_types(), cache); }
  void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  // Sets the modification time, as an archive or `cp -p` does.
  static void set_time(const fs::path& file, time_t seconds) {
    const struct timespec then = {seconds, 0}, times[2] = {then, then};
    ASSERT_EQ(::utimensat(AT_FDCWD, file.c_str(), times, 0), 0);
  }
  // Waits longer than the resolution of the file system's timestamps, so that hashes are remembered.
  static void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(120)); }
  fs::path folder = test::temporary_folder(), cache = folder / "cache";
  fs::path file = folder / "picture";
};

TEST_F(FileHashesTest, SeesACopyThatKeepsTheTime) {
  write(file, "first");
  set_time(file, 1'000'000'000);
  write(folder / "other", "secnd");
  set_time(folder / "other", 1'000'000'000);
  settle();
  FileHashes here(cache);
  EXPECT_EQ(here.hash(file), hash_of("first"));
  fs::rename(folder / "other", file);  // the same size and time
  EXPECT_EQ(here.hash(file), hash_of("secnd"));
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("secnd"));  // in another run
}

TEST_F(FileHashesTest, SeesContentWrittenInPlaceUnderAnOldTime) {
  write(file, "first");
  set_time(file, 1'000'000'000);
  settle();
  FileHashes here(cache);
  EXPECT_EQ(here.hash(file), hash_of("first"));
  write(file, "secnd");
  set_time(file, 1'000'000'000);
  EXPECT_EQ(here.hash(file), hash_of("secnd"));
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("secnd"));
}

TEST_F(FileHashesTest, SeesALinkThatPointsElsewhere) {
  for (const char* name : {"one", "two"}) {
    write(folder / name, name);
    set_time(folder / name, 1'000'000'000);
  }
  fs::create_symlink(folder / "one", file);
  settle();
  FileHashes here(cache);
  EXPECT_EQ(here.hash(file), hash_of("one"));
  fs::remove(file);
  fs::create_symlink(folder / "two", file);
  EXPECT_EQ(here.hash(file), hash_of("two"));
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("two"));
}

TEST_F(FileHashesTest, RemembersAFileThatDoesNotChange) {
  write(file, "first");
  settle();
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("first"));
  // A stored hash that is wrong shows that the file was not read again.
  for (const auto& e : fs::recursive_directory_iterator(cache / "files"))
    if (e.is_regular_file()) {
      std::string line = read_file(e.path()).value();
      line.resize(line.size() - 34);  // the check after it
      line.replace(line.size() - 32, 32, hash_of("lie").text());
      write(e.path(), line + " " + hash_of(line).text() + "\n");
    }
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("lie"));
}

TEST_F(FileHashesTest, BelievesNoMemoWithAFlippedBit) {
  write(file, "first");
  settle();
  EXPECT_EQ(FileHashes(cache).hash(file), hash_of("first"));
  fs::path memo;
  for (const auto& e : fs::recursive_directory_iterator(cache / "files"))
    if (e.is_regular_file()) memo = e.path();
  const std::string text = read_file(memo).value();
  for (std::size_t i = 0; i < text.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] ^= static_cast<char>(1 << bit);
      write(memo, damaged);
      EXPECT_EQ(FileHashes(cache).hash(file), hash_of("first")) << i << " " << bit;
    }
}

// A node that reads its file and then calls `between`, which simulates another program that writes the file.
std::function<void()> between;
std::atomic<int> reads{0};
void read_slowly(Context& c) {
  ++reads;
  const std::string text = read_file(c.files("path").at(0)).value_or("");
  if (between) between();
  c.output("out", Table{{"value"}, {{static_cast<double>(text.size())}}});
}

class ChangingFile : public FileHashesTest {
 protected:
  ChangingFile() {
    registry.add(NodeType("ReadSlowly", 1)
                     .doc_("Length of a file")
                     .output("out", "Table", "The length")
                     .parameter(Parameter::input_path("path").doc_("The file"))
                     .compute_(read_slowly));
    write(file, "one");
    reads = 0;
  }
  ~ChangingFile() override { between = nullptr; }
  RunResult run(Value* value = nullptr) {
    Diagnostics found;
    const Graph g = load_graph_text(
        "terrazzo: 1\nnodes:\n  n: {type: ReadSlowly, params: {path: '" + file.string() + "'}}\n",
        folder / "g.yaml", registry, {}, found);
    EXPECT_FALSE(has_errors(found));
    Store store(test::value_types(), cache);
    FileHashes hashes(cache);
    Evaluator e(test::value_types(), store, hashes);
    RunResult r = e.run(g, {});
    if (value && !r.failed()) *value = e.value(g, r, {0, "out", {}});
    return r;
  }
  Registry registry;
};

TEST_F(ChangingFile, IsReadAgainAndNeverStoredUnderTheOldHash) {
  bool first = true;
  between = [&] {
    if (std::exchange(first, false)) write(file, "other, longer");
  };
  Value value;
  const RunResult r = run(&value);
  ASSERT_EQ(test::count(r, Status::Computed), 1);
  EXPECT_EQ(reads, 2);
  EXPECT_EQ(test::number_of(value), 13);
  // Restore the old content: nothing was stored for it.
  between = nullptr;
  write(file, "one");
  EXPECT_EQ(test::count(run(&value), Status::Computed), 1);
  EXPECT_EQ(test::number_of(value), 3);
}

TEST_F(ChangingFile, ThatNeverRestsIsAnError) {
  int n = 0;
  between = [&] { write(file, std::string(10 + static_cast<std::size_t>(++n), 'x')); };
  const RunResult r = run();
  ASSERT_EQ(test::count(r, Status::Failed), 1);
  EXPECT_EQ(r.nodes[0].error->code, "file-changed");
  EXPECT_EQ(r.nodes[0].error->parameter, "path");
  EXPECT_EQ(reads, 3);
}

TEST_F(ChangingFile, WhoseFirstStateCannotBeReadIsReadAgain) {
  bool first = true;
  between = [&] {
    if (!std::exchange(first, false)) return;
    write(file, "whole");
    throw Error("broken", "half a file");
  };
  Value value;
  EXPECT_EQ(test::count(run(&value), Status::Computed), 1);
  EXPECT_EQ(test::number_of(value), 5);
}

}  // namespace
}  // namespace terrazzo
