#include "runtime/sweep/sweep_log.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "runtime/files.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(SweepLog, GivesEachCompleteLineOnceAndLeavesOutDamagedOnes) {
  const auto file = test::temporary_folder() / "chunk.jsonl";
  LogReader reader(file, false);
  EXPECT_TRUE(reader.news().empty());  // there is no file yet
  const WorkerLog log(file);
  EXPECT_TRUE(log.write({{"event", "started"}, {"point", 1}}));
  std::ofstream(file, std::ios::app) << "{\"event\": \"star\n[1]\n{\"point\": 3}\n\n{\"event\": \"finished\"";
  auto news = reader.news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news[0].at("point"), 1);
  EXPECT_FALSE(news[0].at("host").get<std::string>().empty());
  std::ofstream(file, std::ios::app) << ", \"point\": 2}\n";  // the rest of the line
  news = reader.news();
  ASSERT_EQ(news.size(), 1u);
  EXPECT_EQ(news[0].at("point"), 2);
  EXPECT_TRUE(reader.news().empty());
  LogReader later(file, true);
  EXPECT_TRUE(later.news().empty());
  EXPECT_TRUE(log.write({{"event", "stopped"}}));
  EXPECT_EQ(later.news().size(), 1u);
  // Entries of other types than somebody reads.
  std::ofstream(file, std::ios::app) << "{\"event\": 1}\n{\"event\": \"started\", \"point\": -1}\n"
                                        "{\"event\": \"finished\", \"errors\": [1]}\n"
                                        "{\"event\": \"started\", \"time\": \"now\"}\n";
  EXPECT_TRUE(later.news().empty());
  EXPECT_EQ(later.damaged(), 4u);
  // A pipe in its place neither waits nor gets anything.
  const auto pipe = file.parent_path() / "pipe.jsonl";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(WorkerLog(pipe).write({{"event", "started"}}));
  EXPECT_TRUE(LogReader(pipe, false).news().empty());
  EXPECT_FALSE(WorkerLog(file / "none").write({{"event", "started"}}));
}

}  // namespace
}  // namespace terrazzo
