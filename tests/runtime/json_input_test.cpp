// JSON that others wrote: nested without end, damaged, or not in a regular file.
#include "runtime/files/json_input.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "runtime/sweep/sweep.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

std::string message_of(const std::string& text) {
  try {
    parse_json(text);
  } catch (const Error& e) {
    return e.diagnostic().message;
  }
  return "";
}

TEST(JsonInput, DeepNestingIsRefused) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(parse_json(nested(kDeepestJson)).size(), 1u);
  EXPECT_EQ(message_of(nested(kDeepestJson + 1)), "its values are nested more than 100 deep");
  std::string objects;
  for (int k = 0; k < 1'000'000; ++k) objects += "{\"a\":";
  EXPECT_EQ(message_of(objects), "its values are nested more than 100 deep");
  EXPECT_EQ(json_or_null(nested(1'000'000)), nullptr);
  // Brackets in texts are none.
  const std::string brackets = "\"\\\"" + std::string(1000, '[') + "\"";
  EXPECT_EQ(parse_json(brackets).get<std::string>(), "\"" + std::string(1000, '['));
}

TEST(JsonInput, MessagesNameNoExceptions) {
  const std::string message = message_of("{\"a\": tru}");
  EXPECT_NE(message.find("line 1, column"), std::string::npos) << message;
  EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
  EXPECT_EQ(json_or_null("{"), nullptr);
  EXPECT_EQ(json_or_null(""), nullptr);
}

TEST(JsonInput, FilesThatAreNoneGiveNothing) {
  const fs::path folder = test::temporary_folder();
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::ofstream(folder / "sparse").flush();
  fs::resize_file(folder / "sparse", std::uintmax_t{200} << 30);
  std::ofstream(folder / "good") << "[1]";
  EXPECT_EQ(read_json_file(folder / "pipe"), nullptr);
  EXPECT_EQ(read_json_file(folder / "none"), nullptr);
  EXPECT_EQ(test::code_of([&] { read_json_file(folder / "sparse"); }), "too-large");
  EXPECT_EQ(read_json_file(folder / "good"), json{1});
}

TEST(Reports, ADamagedOneIsNone) {
  const fs::path file = test::temporary_folder() / "report.json";
  const json good = {{"seconds", 1.5},
                     {"sweep", "abc"},
                     {"nodes",
                      {{{"name", "a"},
                        {"status", "done"},
                        {"key", "k"},
                        {"metrics", {{"m", 1}}},
                        {"error", nullptr},
                        {"files", {{{"path", "x"}, {"content", "c"}}}},
                        {"reads", json::array()}}}}};
  const auto read = [&](const json& report) {
    std::ofstream(file) << report.dump();
    return read_report(file);
  };
  EXPECT_EQ(read(good), good);
  EXPECT_EQ(summary_of(read(good)).seconds, 1.5);
  // Whatever entry is missing or of another type.
  const json flat = good.flatten();
  for (const auto& entry : flat.items()) {
    json damaged = good;
    const json::json_pointer at(entry.key());
    damaged[at] = entry.value().is_null() ? json("text") : json(nullptr);
    if (entry.key() == "/nodes/0/metrics/m" || entry.key() == "/nodes/0/reads") continue;  // see below
    EXPECT_EQ(read(damaged), nullptr) << entry.key();
  }
  for (const char* name : {"metrics", "reads", "files", "key", "name", "status"}) {
    json damaged = good;
    damaged["nodes"][0].erase(name);
    EXPECT_EQ(read(damaged), nullptr) << name;
  }
  EXPECT_EQ(read(json::array()), nullptr);
  EXPECT_EQ(read({{"seconds", 1}}), nullptr);
}

}  // namespace
}  // namespace terrazzo
