// A small graph that is evaluated while tests edit it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "runtime/clients/studio/live/live_graph.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

class LiveGraphTest : public ::testing::Test {
 protected:
  using json = nlohmann::json;
  using Document = studio::Document;
  static inline const std::string kLiveText =
      "terrazzo: 1\n"
      "nodes:\n"
      "  a: {type: Constant, params: {value: 5}}\n"
      "  b: {type: Constant, params: {value: 2}}\n"
      "  clamp: {type: Clamp, inputs: {in: a.out}, params: {low: 0, high: 3}}\n"
      "  sum: {type: Add, inputs: {a: clamp.out, b: b.out}}\n"
      "  write: {type: Write, inputs: {in: sum.out}, params: {path: sum.txt}}\n";

  void open(const std::string& text = kLiveText, bool automatic = true) {
    write_text_atomically(file, text);
    live = std::make_unique<studio::LiveGraph>(
        arithmetic(), value_types(),
        SessionOptions{.cache_folder = folder / "cache", .output_folder = folder}, Document(file),
        Overrides{}, automatic);
  }
  void set(const std::string& node, const std::string& name, const std::string& value) {
    live->change([&](Document& d) {
      d.edit({{Edit::Kind::SetParameter, node, name, {false, {value}, {}}}});
    });
  }
  // The state once `ready` holds. Fails after 20 s.
  json when(const std::function<bool(const json&)>& ready) {
    for (int k = 0; k < 2000; ++k) {
      const json s = live->state();
      if (ready(s)) return s;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << live->state().dump(1);
    return live->state();
  }
  json settled() {
    return when([](const json& s) {
      for (const auto& [path, n] : s["nodes"].items())
        if (n["state"] == "waiting" || n["state"] == "running") return false;
      return !s["run"]["running"].get<bool>();
    });
  }
  double number(const json& state, const std::string& node) {
    return number_of(live->value(state["nodes"][node]["outputs"]["out"]["hash"]));
  }

  const std::filesystem::path folder = temporary_folder(), file = folder / "live.yaml";
  std::unique_ptr<studio::LiveGraph> live;
};

}  // namespace terrazzo::test
