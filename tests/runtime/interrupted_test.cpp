// What canceled nodes save.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "nodes/data/table.h"
#include "runtime/context.h"
#include "runtime/files.h"
#include "runtime/interrupted.h"
#include "runtime/session.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

std::atomic<bool> may_finish{false};

// Reports progress until it is canceled, then saves `text`, or fails to if that is empty.
void compute_slowly(Context& c) {
  try {
    while (!may_finish) {
      c.work().check();
      c.work().progress(0.5, "waiting");
      std::this_thread::yield();
    }
  } catch (const Cancelled&) {
    c.save_interrupted(".txt", "half of it", "connect it again", [&](const fs::path& file) {
      if (c.text("text").empty())
        throw Error("write-failed", "the file is incomplete: no space", "free some");
      std::ofstream(file) << c.text("text");
    });
    throw;
  }
  c.output("out", Table{{"value"}, {{1.0}}});
}

const Registry& slow_nodes() {
  static const Registry registry = [] {
    Registry r;
    r.add(NodeType("Slow", 1)
              .doc_("test")
              .output("out", "Table", "result")
              .parameter(Parameter::text("text", "half").doc_("saved"))
              .compute_(compute_slowly));
    return r;
  }();
  return registry;
}

struct Waiting : Observer {
  std::atomic<bool> runs{false};
  void progress(int, double, const std::string&) override { runs = true; }
  void wait() const {
    while (!runs) std::this_thread::yield();
  }
};

class Interrupted : public ::testing::Test {
 protected:
  fs::path out = test::temporary_folder() / "out";
  std::unique_ptr<Session> session = session_with(nullptr);
  Waiting observer;

  std::unique_ptr<Session> session_with(const std::atomic<bool>* cancel) {
    may_finish = false;
    auto s = std::make_unique<Session>(slow_nodes(), test::value_types(),
                                       SessionOptions{.output_folder = out, .cancel = cancel});
    for (const auto& d : s->open_text("terrazzo: 1\nnodes: {pack: {type: Slow}}\n", "g.yaml"))
      ADD_FAILURE() << d.text();
    return s;
  }
  NodeResult interrupted() {
    observer.runs = false;
    const auto running = session->evaluate({}, &observer);
    observer.wait();
    running->cancel();
    return running->wait().nodes.at(0);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    if (fs::is_directory(out))
      for (const auto& e : fs::directory_iterator(out)) names.push_back(e.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(Interrupted, ACanceledEvaluationSavesWhatItReached) {
  const NodeResult r = interrupted();
  EXPECT_EQ(r.status, Status::Cancelled);
  ASSERT_TRUE(r.saved);
  EXPECT_EQ(r.saved->file, out / "pack.interrupted.txt");
  EXPECT_EQ(r.saved->message.text(), "g.yaml:2:9: note: pack: interrupted; saved half of it in '" +
                                         (out / "pack.interrupted.txt").string() + "' (connect it again)");
  EXPECT_EQ(read_file(r.saved->file), "half");
  EXPECT_TRUE(r.files.empty());
}

TEST_F(Interrupted, CtrlCSavesWhatWasReached) {
  std::atomic<bool> cancel{false};
  session = session_with(&cancel);
  const auto running = session->evaluate({}, &observer);
  observer.wait();
  cancel = true;
  const NodeResult& r = running->wait().nodes.at(0);
  ASSERT_TRUE(r.saved);
  EXPECT_EQ(files(), std::vector<std::string>{"pack.interrupted.txt"});
}

TEST_F(Interrupted, AnEarlierFileStays) {
  interrupted();
  session->set("pack.text", "more");
  const NodeResult r = interrupted();
  EXPECT_EQ(r.saved->file, out / "pack.interrupted_2.txt");
  EXPECT_EQ(read_file(out / "pack.interrupted.txt"), "half");
  EXPECT_EQ(read_file(out / "pack.interrupted_2.txt"), "more");
}

TEST_F(Interrupted, AnEditSavesNothing) {
  const auto running = session->evaluate({}, &observer);
  observer.wait();
  session->set("pack.text", "another");
  const NodeResult& r = running->wait().nodes.at(0);
  EXPECT_EQ(r.status, Status::Cancelled);
  EXPECT_FALSE(r.saved);
  EXPECT_EQ(files(), std::vector<std::string>{});
}

TEST_F(Interrupted, AWriterThatFailsLeavesNoFile) {
  session->set("pack.text", "");
  const NodeResult r = interrupted();
  EXPECT_EQ(r.status, Status::Cancelled);
  ASSERT_TRUE(r.saved);
  EXPECT_TRUE(r.saved->file.empty());
  EXPECT_EQ(r.saved->message.severity, Severity::Warning);
  EXPECT_EQ(r.saved->message.message, "interrupted; cannot save its work in '" +
                                          (out / "pack.interrupted.txt").string() +
                                          "': the file is incomplete: no space");
  EXPECT_EQ(files(), std::vector<std::string>{});
}

TEST_F(Interrupted, AFolderThatCannotBeWrittenIsReported) {
  std::ofstream(out) << "a file stands where the folder should be";
  const NodeResult r = interrupted();
  EXPECT_EQ(r.status, Status::Cancelled);
  ASSERT_TRUE(r.saved);
  EXPECT_EQ(r.saved->message.code, "write-failed");
  EXPECT_NE(r.saved->message.message.find("pack.interrupted.txt'"), std::string::npos)
      << r.saved->message.message;
}

TEST_F(Interrupted, TheNameShowsTheSubgraph) {
  GraphNode node;
  node.path = "asset/pack";
  const SavedWork saved =
      save({".json", "it", "", [](const fs::path& file) { std::ofstream(file) << "{}"; }}, node, out);
  EXPECT_EQ(saved.file, out / "asset.pack.interrupted.json");
  EXPECT_EQ(files(), std::vector<std::string>{"asset.pack.interrupted.json"});
}

// What was saved is no result: the node runs again and gives what it would have given.
TEST_F(Interrupted, NothingIsCached) {
  const NodeResult first = interrupted();
  EXPECT_TRUE(first.outputs.empty());
  may_finish = true;
  const auto again = session->evaluate();
  const NodeResult& r = again->wait().nodes.at(0);
  EXPECT_EQ(r.status, Status::Computed);
  EXPECT_FALSE(r.saved);
  EXPECT_EQ(r.key, first.key);
  session = session_with(nullptr);
  may_finish = true;
  EXPECT_EQ(session->evaluate()->wait().nodes.at(0).outputs.at("out"), r.outputs.at("out"));
}

}  // namespace
}  // namespace terrazzo
