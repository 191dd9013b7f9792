// Runs the node, and checks what holds for every packing.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/packing/rigid/statistics.h"
#include "tests/nodes/packing/anneal/brute_force.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo::test {

inline NodeRun pack(const Shapes& shapes, const SizeDistribution& d,
                    std::map<std::string, std::string> parameters, int threads = 2,
                    const Particles* start = nullptr) {
  std::multimap<std::string, Value> inputs{{"shapes", Value::of<Shapes>(shapes)},
                                           {"distribution", Value::of<SizeDistribution>(d)}};
  if (start) inputs.emplace("start", Value::of<Particles>(*start));
  return run_node("Anneal", inputs, parameters, {}, threads);
}

inline std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.diagnostic().code + ": " + e.diagnostic().message;
  }
  return "no error";
}

inline void expect_sound(const Shapes& shapes, const NodeRun& run, double fraction) {
  const auto& p = run.output<Particles>("particles");
  EXPECT_EQ(run.metrics.at("max_penetration"), 0);
  EXPECT_EQ(brute::overlaps(shapes, p), 0);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), fraction, 0.01 * fraction);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), packing::volume_fraction(shapes, p), 1e-12);
  for (std::size_t i = 0; i < p.count(); ++i) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(p.position[i][a], 0);
      EXPECT_LT(p.position[i][a], p.box[a]);
    }
    EXPECT_NEAR(p.orientation[i].norm(), 1, 1e-9);
    EXPECT_NEAR(p.scale[i] * shapes.shapes[p.shape[i]].size(), p.size[i], 1e-9);
  }
}

}  // namespace terrazzo::test
