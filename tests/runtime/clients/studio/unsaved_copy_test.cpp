// Unsaved text beside a graph: of several Studios at a time, after crashes, and of private graphs.
#include "runtime/clients/studio/live/unsaved_copy.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/clients/studio/live/document.h"
#include "runtime/files.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using studio::Document;
using studio::UnsavedCopy;

const std::string kText = "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 5}}\n";

class Unsaved : public ::testing::Test {
 protected:
  Unsaved() { write_text_atomically(file, kText); }
  std::string copy(const std::string& end = "") const {
    return read_file(file.parent_path() / (".graph.yaml.unsaved" + end)).value_or("");
  }
  static unsigned mode(const fs::path& path) {
    struct stat s = {};
    ::stat(path.c_str(), &s);
    return s.st_mode & 0777;
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(file.parent_path()), {}));
  }
  const fs::path file = test::temporary_folder() / "graph.yaml";
};

TEST_F(Unsaved, TwoStudiosOnOneFileKeepTheirOwnText) {
  Document one(file), two(file);
  one.replace(kText + "# one\n");
  two.replace(kText + "# two\n");
  EXPECT_EQ(copy(), one.text());
  EXPECT_EQ(copy("_2"), two.text());
  EXPECT_EQ(Document(file).recovered(), "");  // both still run
  two.save(false);
  EXPECT_EQ(copy(), one.text());
  EXPECT_EQ(copy("_2"), "");
  one.replace(one.text() + "# more\n");
  EXPECT_EQ(copy(), one.text());
}

TEST_F(Unsaved, ACopyBelongsToAnotherProcessAsLongAsItRuns) {
  int ready[2], end[2];
  ASSERT_EQ(::pipe(ready) | ::pipe(end), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    Document d(file);
    d.replace(kText + "# child\n");
    char byte = 0;
    [[maybe_unused]] auto n = ::write(ready[1], &byte, 1);
    n = ::read(end[0], &byte, 1);
    ::_exit(0);  // without destructors, as after a crash
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  EXPECT_EQ(Document(file).recovered(), "");
  ASSERT_EQ(::write(end[1], &byte, 1), 1);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(Document(file).recovered(), kText + "# child\n");
  for (const int fd : {ready[0], ready[1], end[0], end[1]}) ::close(fd);
}

TEST_F(Unsaved, SavingAfterACrashDeletesNothingThatIsOffered) {
  { Document(file).replace(kText + "# lost\n"); }
  Document d(file);
  EXPECT_EQ(d.recovered(), kText + "# lost\n");
  d.save(true);
  EXPECT_EQ(copy(), kText + "# lost\n");
  EXPECT_EQ(d.recovered(), kText + "# lost\n");
  // Another Studio that starts now neither offers nor deletes it.
  EXPECT_EQ(Document(file).recovered(), "");
  d.recover(true);
  EXPECT_EQ(d.text(), kText + "# lost\n");
  d.save(false);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(read_file(file), kText + "# lost\n");
}

TEST_F(Unsaved, WhatSeveralSessionsLeftIsOfferedInTurn) {
  {
    Document one(file), two(file);
    one.replace(kText + "# one\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // by the clock of the file system
    two.replace(kText + "# two\n");
  }
  Document d(file);
  EXPECT_EQ(d.recovered(), kText + "# two\n");
  d.recover(false);
  EXPECT_EQ(d.recovered(), kText + "# one\n");
  d.replace(kText + "# three\n");
  d.recover(true);
  EXPECT_EQ(d.text(), kText + "# one\n");
  EXPECT_EQ(d.recovered(), "");
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.text(), kText + "# three\n");
  EXPECT_EQ(files(), 2u);
}

TEST_F(Unsaved, TheSameFileIsOpenedAgainWithWhatWasNotSaved) {
  Document d(file);
  d.replace(kText + "# mine\n");
  Document again(file);
  EXPECT_EQ(again.recovered(), "");
  d = std::move(again);
  d.look_for_left();
  EXPECT_EQ(d.recovered(), kText + "# mine\n");
}

TEST_F(Unsaved, CopiesHaveThePermissionsOfTheGraph) {
  for (const unsigned given : {0600u, 0640u, 0644u, 0400u}) {
    ASSERT_EQ(::chmod(file.c_str(), given), 0);
    Document d(file);
    d.replace(kText + "# secret\n");
    EXPECT_EQ(mode(file.parent_path() / ".graph.yaml.unsaved"), given | 0600) << std::oct << given;
    d.arrange(studio::arrangement_text({{"places", {{"a", {1, 2}}}}}));
    EXPECT_EQ(mode(studio::arrangement_file(file)), given) << std::oct << given;
    d.save(true);
    EXPECT_EQ(mode(file), given) << std::oct << given;
    EXPECT_EQ(files(), 2u);
    d.replace(kText);
    d.save(true);
    d.arrange("");
  }
}

TEST_F(Unsaved, WhatIsNoCopyIsLeftAlone) {
  const fs::path folder = file.parent_path();
  ASSERT_EQ(::mkfifo((folder / ".graph.yaml.unsaved").c_str(), 0600), 0);
  std::ofstream(folder / ".graph.yaml.unsaved_2").flush();
  fs::resize_file(folder / ".graph.yaml.unsaved_2", std::uintmax_t{200} << 30);
  std::ofstream(folder / ".graph.yaml.unsaved_3") << "\xff";
  std::ofstream(folder / "victim") << kText << "# victim\n";
  fs::create_symlink("victim", folder / ".graph.yaml.unsaved_4");
  std::ofstream(folder / ".graph.yaml.unsaved_x") << "theirs";
  Document d(file);
  EXPECT_EQ(d.recovered(), "");
  d.replace(kText + "# mine\n");
  EXPECT_EQ(copy("_5"), d.text());
  d.save(false);
  EXPECT_EQ(copy("_5"), "");
  EXPECT_EQ(read_file(folder / "victim"), kText + "# victim\n");
  EXPECT_EQ(files(), 7u);
}

TEST_F(Unsaved, ACopyOfAnEarlierVersionIsOffered) {
  std::ofstream(file.parent_path() / ".graph.yaml.unsaved") << kText << "# earlier\n";
  EXPECT_EQ(Document(file).recovered(), kText + "# earlier\n");
  std::ofstream(file.parent_path() / ".graph.yaml.unsaved") << kText;  // saved since
  EXPECT_EQ(Document(file).recovered(), "");
  EXPECT_EQ(files(), 1u);
}

TEST_F(Unsaved, GraphsWithOneStemHaveTheirOwnNotes) {
  const fs::path other = file.parent_path() / "graph.yml";
  write_text_atomically(other, kText);
  const auto at = [](int x) { return studio::arrangement_text({{"places", {{"a", {x, 0}}}}}); };
  Document one(file), two(other);
  one.arrange(at(1));
  two.arrange(at(2));
  EXPECT_EQ(Document(file).arrangement(), at(1));
  EXPECT_EQ(Document(other).arrangement(), at(2));
  two.arrange("");
  EXPECT_EQ(Document(file).arrangement(), at(1));
}

TEST_F(Unsaved, NotesOfAnEarlierVersionMoveWithTheFirstChange) {
  const fs::path former = file.parent_path() / "graph.studio.json", other = file.parent_path() / "graph.yml";
  const auto at = [](int x) { return studio::arrangement_text({{"places", {{"a", {x, 0}}}}}); };
  write_text_atomically(former, at(1));
  write_text_atomically(other, kText);
  Document one(file);
  EXPECT_EQ(one.arrangement(), at(1));
  one.arrange("");
  EXPECT_EQ(Document(file).arrangement(), "");
  EXPECT_EQ(Document(other).arrangement(), at(1));  // both had read the one file
  fs::remove(file);
  Document two(other);
  two.arrange(at(2));
  EXPECT_FALSE(fs::exists(former));
  EXPECT_EQ(read_file(studio::arrangement_file(other)), at(2));
  // Another file of that name stays.
  write_text_atomically(former, "[1]");
  two.arrange("");
  EXPECT_EQ(read_file(former), "[1]");
}

}  // namespace
}  // namespace terrazzo
