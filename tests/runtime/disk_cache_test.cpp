#include "runtime/cache/disk_cache.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <functional>

#include "nodes/data/table.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/evaluate.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::count;
using test::graph_of;
using test::paths;
using Paths = std::vector<std::string>;

class DiskCache : public ::testing::Test {
 protected:
  RunResult run(const Graph& g, std::uint64_t memory = Store::kDefaultMemory) {
    Store store(test::value_types(), cache, memory);
    FileHashes hashes;
    RunOptions o;
    o.output_folder = folder / "out";
    return Evaluator(test::value_types(), store, hashes).run(g, o);
  }
  Verified verify(std::uint64_t sample) {
    return verify_cache(cache, test::arithmetic(), test::value_types(), sample, 1, Work());
  }
  static void age(const fs::path& file, double seconds) {
    struct timespec now;
    ::clock_gettime(CLOCK_REALTIME, &now);
    const struct timespec then = {now.tv_sec - static_cast<time_t>(seconds), 0}, times[2] = {then, then};
    ::utimensat(AT_FDCWD, file.c_str(), times, 0);
  }
  fs::path folder = test::temporary_folder(), cache = folder / "cache";
};

const std::string three =
    "nodes:\n"
    "  small: {type: Big, params: {rows: 10}}\n"
    "  big: {type: Big, inputs: {in: small.out}, params: {rows: 20000}}\n"
    "  end: {type: Clamp, inputs: {in: big.out}}\n";

TEST_F(DiskCache, StatsCountWhatIsThere) {
  run(graph_of(three));
  const CacheStats s = cache_stats(cache);
  EXPECT_EQ(s.records.count, 3u);
  EXPECT_EQ(s.values.count, 1u);
  EXPECT_EQ(s.in_records, 2u);
  EXPECT_EQ(s.by_type.at("Table").count, 3u);
  EXPECT_EQ(s.by_type.at("Table").bytes, s.values.bytes);
  EXPECT_GT(s.values.bytes, 20000u * 8);
}

TEST_F(DiskCache, CollectingKeepsWithinTheLimitAndNoResultIsLost) {
  const Graph g = graph_of(three);
  const RunResult first = run(g);
  EXPECT_GE(collect_cache(cache, 100'000).values, 1u);  // at least the large one
  EXPECT_LE(cache_stats(cache).bytes(), 100'000u);
  // No node needs its value, so nothing runs.
  const RunResult second = run(g);
  EXPECT_EQ(count(second, Status::Disk), 3);
  // A node needs its value, so it runs again, but not its source.
  const Graph changed = graph_of(three, {{{"end.high", "0.5"}}, {}});
  const RunResult third = run(changed);
  EXPECT_GE(count(third, Status::Computed), 2);
  EXPECT_EQ(third.nodes[static_cast<std::size_t>(g.find("end"))].status, Status::Computed);
  EXPECT_EQ(third.nodes[static_cast<std::size_t>(g.find("big"))].status, Status::Computed);
  const auto big = static_cast<std::size_t>(g.find("big"));
  EXPECT_EQ(third.nodes[big].outputs, first.nodes[big].outputs);
}

TEST_F(DiskCache, CollectingRemovesLeftoversOfKilledWriters) {
  run(graph_of(three));
  const fs::path old = cache / "values" / ".incoming-1-1.1.1.tmp",
                 fresh = cache / "values" / ".incoming-1-2.1.1.tmp";
  std::ofstream(old) << "half a value";
  std::ofstream(fresh) << "being written";
  age(old, 7200);
  EXPECT_EQ(collect_cache(cache, 1'000'000'000).leftovers, 1u);
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(fresh));
}

TEST_F(DiskCache, ClearingTouchesNothingThatIsNotOurs) {
  run(graph_of(three));
  std::ofstream(cache / "notes.txt") << "mine";
  clear_cache(cache);
  EXPECT_TRUE(fs::exists(cache / "notes.txt"));
  EXPECT_EQ(cache_stats(cache).values.count, 0u);
  EXPECT_EQ(count(run(graph_of(three)), Status::Computed), 3);
}

TEST_F(DiskCache, VerifyComputesAgainAndCompares) {
  run(graph_of(three));
  Verified v = verify(100);
  EXPECT_EQ(v.values, 3u);
  EXPECT_EQ(v.recomputed, 3u);  // `big` reads a value that is in a record
  EXPECT_EQ(v.passed_over, 0u);
  EXPECT_TRUE(v.damaged.empty());
  EXPECT_TRUE(v.differing.empty());
}

TEST_F(DiskCache, VerifyFindsARecordThatLies) {
  // A well-formed record with the result of another computation.
  const Graph g = graph_of(
      "nodes:\n  a: {type: Constant, params: {value: 1}}\n  b: {type: Constant, params: {value: 2}}\n");
  const RunResult r = run(g);
  {
    Store store(test::value_types(), cache);
    Tier tier;
    ActionRecord lie = *store.find_action(r.nodes[0].key, tier);
    lie.outputs = store.find_action(r.nodes[1].key, tier)->outputs;
    store.put_action(r.nodes[0].key, std::make_shared<ActionRecord>(lie));
  }
  const Verified v = verify(100);
  ASSERT_EQ(v.differing.size(), 1u);
  EXPECT_NE(v.differing[0].find("Constant " + r.nodes[0].key.text()), std::string::npos);
  EXPECT_EQ(paths(g, run(g), Status::Computed), (Paths{"a"}));
}

// As of a plugin that was changed without a new version.
TEST_F(DiskCache, ARecordWithOtherOutputsIsComputedAgain) {
  const Graph g = graph_of(three);
  const RunResult first = run(g);
  const auto damage = [&](const auto& change) {
    Store store(test::value_types(), cache);
    for (const auto& n : first.nodes) {
      Tier tier;
      ActionRecord r = *store.find_action(n.record, tier);
      change(r);
      store.put_action(n.record, std::make_shared<const ActionRecord>(std::move(r)));
    }
  };
  const auto rename = [](ActionRecord& r) {
    r.outputs["other"] = r.outputs.at("out");
    r.outputs.erase("out");
  };
  const auto another_type = [](ActionRecord& r) { r.outputs.at("out").type = "Image"; };
  const auto none = [](ActionRecord& r) { r.outputs.clear(); };
  for (const std::function<void(ActionRecord&)>& change :
       {std::function<void(ActionRecord&)>(rename), std::function<void(ActionRecord&)>(another_type),
        std::function<void(ActionRecord&)>(none)}) {
    damage(change);
    const RunResult r = run(g);
    EXPECT_EQ(count(r, Status::Computed), 3);
    EXPECT_EQ(count(run(g), Status::Disk), 3);
    damage(change);
    EXPECT_EQ(verify(0).damaged.size(), 3u);
    EXPECT_EQ(cache_stats(cache).records.count, 0u);
    run(g);
  }
}

TEST_F(DiskCache, AValueOfAnotherSizeIsNotRead) {
  const Graph g = graph_of(three);
  const RunResult first = run(g);
  const OutputRecord& big = first.nodes[static_cast<std::size_t>(g.find("big"))].outputs.at("out");
  const fs::path file = cache_entry(cache, "values", big.content);
  fs::resize_file(file, std::uintmax_t{200} << 30);
  Store store(test::value_types(), cache);
  EXPECT_FALSE(store.get_value(big));
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(verify(0).lost, 1u);
}

TEST_F(DiskCache, CountsWhatAnotherProcessComputedMeanwhile) {
  const auto record = [](double seconds, std::uint64_t content) {
    ActionRecord r;
    r.type = "Constant", r.seconds = seconds, r.outputs["out"] = {"Table", {0, content}, 8};
    return std::make_shared<const ActionRecord>(r);
  };
  const Hash key{1, 2}, other{3, 4};
  Store here(test::value_types(), cache), there(test::value_types(), cache);
  Tier tier;
  for (Store* store : {&here, &there}) {
    EXPECT_FALSE(store->find_action(key, tier));
    EXPECT_FALSE(store->find_action(other, tier));
  }
  here.put_action(key, record(1, 5));
  there.put_action(key, record(2, 5));
  EXPECT_EQ(here.computed_twice().count, 0u);
  EXPECT_EQ(there.computed_twice().count, 1u);
  EXPECT_EQ(there.computed_twice().seconds, 2);
  EXPECT_EQ(there.computed_twice().differing, 0u);
  there.put_action(other, record(1, 6));
  here.put_action(other, record(1, 7));  // on a machine that computes other bits
  EXPECT_EQ(here.computed_twice().differing, 1u);
  EXPECT_EQ(Store(test::value_types(), cache).find_action(other, tier)->outputs.at("out").content.low, 6u);
  here.put_action(key, record(1, 5));  // replacing its own is no second computation
  EXPECT_EQ(here.computed_twice().count, 1u);
}

TEST_F(DiskCache, AValueThatComesOutOtherwiseTheSecondTimeIsAnError) {
  const Graph g = graph_of(three);
  const RunResult r = run(g);
  const auto small = static_cast<std::size_t>(g.find("small"));
  {
    Store store(test::value_types(), cache);
    Tier tier;
    ActionRecord lie = *store.find_action(r.nodes[small].key, tier);
    lie.outputs.at("out").content.low ^= 1;
    lie.outputs.at("out").small.reset();
    store.put_action(r.nodes[small].key, std::make_shared<ActionRecord>(lie));
  }
  const RunResult second = run(g);  // `big` now has a different input, and needs a value that does not exist
  ASSERT_EQ(paths(g, second, Status::Failed), (Paths{"big"}));
  const Diagnostic& d = *second.nodes[static_cast<std::size_t>(g.find("big"))].error;
  EXPECT_EQ(d.code, "not-deterministic");
  EXPECT_EQ(d.node, "small");
  EXPECT_EQ(count(run(g), Status::Failed), 0);  // the record was removed, so it is recomputed
}

TEST_F(DiskCache, AGraphLargerThanTheMemoryRunsThroughTheDisk) {
  std::string text = "nodes:\n";
  std::string all;
  for (int i = 0; i < 20; ++i) {
    text += "  n" + std::to_string(i) + ": {type: Big, params: {rows: 10000, value: " + std::to_string(i) +
            "}}\n";
    all += (i ? ", n" : "n") + std::to_string(i) + ".out";
  }
  const Graph g = graph_of(text + "  sum: {type: Sum, inputs: {in: [" + all + "]}}\n");
  const RunResult r = run(g, 1000);  // less than any value
  EXPECT_EQ(count(r, Status::Computed), 21);
  Store store(test::value_types(), cache);
  EXPECT_EQ(test::number_of(store.get_value(r.nodes.back().outputs.at("out"))), 190);
}

TEST(MemoryStore, TheLeastSecondsPerByteLeaveFirst) {
  Store store(test::value_types(), {}, 1000);
  const Graph g = graph_of("nodes:\n  a: {type: Constant}\n");
  const auto value = [](double v, std::size_t rows) {
    Table t{{"value"}, {}};
    t.rows.assign(rows, {v});
    return Value::of(t);
  };
  const OutputRecord cheap = store.put_value(value(1, 40), 0.001), dear = store.put_value(value(2, 40), 10);
  const OutputRecord third = store.put_value(value(3, 40), 1);
  ASSERT_GT(cheap.bytes + dear.bytes + third.bytes, 1000u);
  ASSERT_LT(dear.bytes + third.bytes, 1000u);
  EXPECT_FALSE(store.has_value(cheap));
  EXPECT_TRUE(store.has_value(dear));
  EXPECT_TRUE(store.has_value(third));
}

}  // namespace
}  // namespace terrazzo
