// Small values are stored in the records of the computations that made them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/data/table.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/cache/value_file.h"
#include "runtime/evaluate.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::count;
using test::graph_of;

const std::string text =
    "nodes:\n"
    "  a: {type: Constant, params: {value: 3}}\n"
    "  b: {type: Clamp, inputs: {in: a.out}, params: {high: 2}}\n";

class SmallValues : public ::testing::Test {
 protected:
  // As a process of its own.
  RunResult run(const Graph& g) {
    Store store(test::value_types(), cache);
    FileHashes hashes;
    return Evaluator(test::value_types(), store, hashes).run(g, {});
  }
  double value_of(const OutputRecord& output) {
    Store store(test::value_types(), cache);
    const Value v = store.get_value(output);
    return v ? test::number_of(v) : std::nan("");
  }
  std::shared_ptr<const ActionRecord> record(const Hash& key) {
    Tier tier;
    return Store(test::value_types(), cache).find_action(key, tier);
  }
  std::size_t files(const char* table) {
    std::size_t n = 0;
    each_cache_file(cache, table, -1, [&](const CacheFile&) { ++n; });
    return n;
  }
  // Changes the JSON of a record, and its checksum.
  void edit(const Hash& key, const std::function<void(json&)>& change) {
    const fs::path file = cache_entry(cache, "actions", key);
    json j = json::parse(read_file(file)->substr(33));
    change(j);
    const std::string body = j.dump();
    std::ofstream(file, std::ios::binary) << hash_of(body).text() << "\n" << body;
  }
  fs::path folder = test::temporary_folder(), cache = folder / "cache";
};

TEST_F(SmallValues, HaveNoFilesOfTheirOwn) {
  const Graph g = graph_of(text);
  const RunResult first = run(g);
  EXPECT_EQ(files("actions"), 2u);
  EXPECT_EQ(files("values"), 0u);
  const RunResult second = run(g);
  EXPECT_EQ(count(second, Status::Disk), 2);
  EXPECT_EQ(second.nodes[1].outputs, first.nodes[1].outputs);
  EXPECT_EQ(value_of(second.nodes[1].outputs.at("out")), 2);
  // Another node reads the value from the record of its source.
  const RunResult third = run(graph_of(text, {{{"b.high", "9"}}, {}}));
  EXPECT_EQ(third.nodes[0].status, Status::Disk);
  EXPECT_EQ(third.nodes[1].status, Status::Computed);
  EXPECT_EQ(value_of(third.nodes[1].outputs.at("out")), 3);
}

TEST_F(SmallValues, AreThoseOfAtMostTwoKilobytes) {
  for (const std::size_t more : {0u, 1u}) {
    Store store(test::value_types(), cache);
    const std::size_t head = store.put_value(Value::of(Table{{""}, {}})).bytes;
    const Value v = Value::of(Table{{std::string(kSmallValue - head + more, 'x')}, {}});
    const OutputRecord output = store.put_value(v, 1);
    EXPECT_EQ(output.bytes, kSmallValue + more);
    EXPECT_EQ(output.small != nullptr, more == 0);
    EXPECT_EQ(files("values"), more);
    Store other(test::value_types(), cache);
    EXPECT_TRUE(other.has_value(output));
    const Value back = other.get_value(output);
    ASSERT_TRUE(back);
    EXPECT_EQ(back.as<Table>().columns, v.as<Table>().columns);
  }
}

TEST_F(SmallValues, ARecordWithoutItsValueIsRenewedWhenTheValueIsNeeded) {
  const RunResult first = run(graph_of(text));
  const Hash key = first.nodes[0].record;
  edit(key, [](json& j) { j["outputs"]["out"].erase("value"); });
  ASSERT_FALSE(record(key)->outputs.at("out").small);
  const RunResult second = run(graph_of(text));  // nothing needs it
  EXPECT_EQ(count(second, Status::Disk), 2);
  EXPECT_FALSE(record(key)->outputs.at("out").small);
  const RunResult third = run(graph_of(text, {{{"b.high", "9"}}, {}}));
  EXPECT_EQ(count(third, Status::Computed), 2);
  ASSERT_TRUE(record(key)->outputs.at("out").small);
  EXPECT_EQ(value_of(record(key)->outputs.at("out")), 3);
}

TEST_F(SmallValues, FilesOfEarlierVersionsAreRead) {
  const RunResult first = run(graph_of(text));
  const OutputRecord output = record(first.nodes[0].record)->outputs.at("out");
  edit(first.nodes[0].record, [](json& j) { j["outputs"]["out"].erase("value"); });
  const fs::path place = cache_entry(cache, "values", output.content);
  fs::create_directories(place.parent_path());
  std::ofstream(place, std::ios::binary) << value_head(1) << *output.small;
  const RunResult second = run(graph_of(text, {{{"b.high", "9"}}, {}}));
  EXPECT_EQ(second.nodes[0].status, Status::Disk);
  EXPECT_EQ(value_of(second.nodes[1].outputs.at("out")), 3);
}

TEST_F(SmallValues, ARecordWithAnotherValueIsDamaged) {
  const RunResult first = run(graph_of(text));
  const Hash a = first.nodes[0].record, b = first.nodes[1].record;
  std::string other;
  edit(b, [&](json& j) { other = j["outputs"]["out"]["value"]; });
  for (const std::string& value : {other, std::string("###"), std::string()}) {
    edit(a, [&](json& j) { j["outputs"]["out"]["value"] = value; });
    EXPECT_FALSE(record(a)) << value;
    EXPECT_FALSE(fs::exists(cache_entry(cache, "actions", a))) << value;
    const RunResult again = run(graph_of(text));
    EXPECT_EQ(again.nodes[0].status, Status::Computed);
    EXPECT_EQ(again.nodes[0].outputs, first.nodes[0].outputs);
  }
  edit(a, [](json& j) { j["outputs"]["out"]["value"] = 7; });
  EXPECT_FALSE(record(a));
}

TEST_F(SmallValues, OfInputsAreNotStoredAgain) {
  const RunResult first = run(graph_of(text));
  edit(first.nodes[1].record, [](json& j) {
    EXPECT_TRUE(j["outputs"]["out"].contains("value"));
    EXPECT_FALSE(j["inputs"]["in"][0].contains("value"));
  });
}

}  // namespace
}  // namespace terrazzo
