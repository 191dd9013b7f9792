// Which solid is kept.
#include "nodes/compare/choose_solid/choice.h"

#include <gtest/gtest.h>

#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace choose_solid;
using Inputs = std::multimap<std::string, Value>;

Table observers(double patterns, double features, double error) {
  return {{"observer", "accuracy %", "standard error %"},
          {{"patterns", patterns, error}, {"features", features, error}}};
}

// A solid whose picture has this gray.
void add_solid(Inputs& inputs, const std::string& route, float gray) {
  Image picture(4, 4, 1, 0.1);
  picture.at(0, 0) = Vec3f::Constant(gray);
  Volume volume;
  const auto grid = openvdb::FloatGrid::create(gray);
  grid->setName("density");
  volume.grids.push_back(grid);
  inputs.emplace(route, Value::of(picture));
  inputs.emplace(route + "_block", Value::of(picture));
  inputs.emplace(route + "_volume", Value::of(volume));
}

float kept(const Inputs& inputs, const std::string& route = "auto") {
  const auto run = test::run_node("ChooseSolid", inputs, {{"route", route}});
  EXPECT_EQ(run.output<Image>("picture").at(0, 0).x(), run.output<Image>("block").at(0, 0).x());
  EXPECT_EQ(run.output<Table>("table").rows.size(), 3u);
  return run.output<Image>("picture").at(0, 0).x();
}

TEST(ChooseSolid, KeepsTheLessRecognizedOneBeyondTwoStandardErrors) {
  const auto better = [](double particles, double exemplar, double error) {
    Route a{"particles", true, {}, {}}, b{"exemplar", true, {}, {}};
    read_observers(observers(60, particles, error), a);
    read_observers(observers(exemplar, 55, error), b);
    return choose({{"phases", false, {}, {}}, a, b}).route;
  };
  EXPECT_EQ(better(80, 95, 2), 1u);
  EXPECT_EQ(better(95, 80, 2), 2u);
  EXPECT_EQ(better(85, 80, 2), 1u);  // 5 is below 2 · √8
  EXPECT_EQ(better(86, 80, 2), 2u);
  EXPECT_EQ(better(80, 80, 0), 1u);
}

TEST(ChooseSolid, TakesWhatThereIs) {
  Inputs inputs;
  add_solid(inputs, "exemplar", 0.25f);
  EXPECT_EQ(kept(inputs), 0.25f);
  add_solid(inputs, "particles", 0.5f);
  EXPECT_EQ(kept(inputs), 0.5f);  // without observers
  EXPECT_EQ(kept(inputs, "exemplar"), 0.25f);
  inputs.emplace("particles_observers", Value::of(observers(99, 98, 1)));
  inputs.emplace("exemplar_observers", Value::of(observers(70, 80, 1)));
  EXPECT_EQ(kept(inputs), 0.25f);
  add_solid(inputs, "phases", 0.75f);
  EXPECT_EQ(kept(inputs), 0.75f);
  EXPECT_EQ(kept(inputs, "particles"), 0.5f);
}

TEST(ChooseSolid, ErrorsSayWhatIsMissing) {
  Inputs inputs;
  const auto code = [&](const std::string& route) {
    return test::code_of([&] { test::run_node("ChooseSolid", inputs, {{"route", route}}); });
  };
  EXPECT_EQ(code("auto"), "no-solid");
  add_solid(inputs, "exemplar", 0.25f);
  EXPECT_EQ(code("phases"), "no-solid");
  inputs.emplace("phases", Value::of(Image(4, 4, 1, 0.1)));  // a part of a solid is none
  EXPECT_EQ(code("phases"), "no-solid");
  EXPECT_EQ(kept(inputs), 0.25f);
  EXPECT_EQ(test::run_node("ChooseSolid", inputs).warnings.size(), 1u);
}

}  // namespace
}  // namespace terrazzo
