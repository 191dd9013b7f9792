#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/study/shape_study/screens.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace shape_study;

const std::vector<Stimulus> kStimuli{
    {"smooth", "original", 5}, {"smooth", "csg", 3}, {"complex", "csg", 4}, {"complex", "original", 3}};

TEST(ShapeStudy, ScreensAreAsThePaperHasThem) {
  const auto screens = make_screens(kStimuli, 40, 3);
  std::map<std::string, int> count;
  for (const auto& s : screens) {
    ++count[s.shape + "/" + s.method + "/" + s.decoy];
    const auto& original = kStimuli[static_cast<std::size_t>(s.center.stimulus)];
    EXPECT_EQ(original.method, "original");
    EXPECT_EQ(original.shape, s.shape);
    const auto& same = s.decoy == "left" ? s.right : s.left;
    EXPECT_EQ(same.stimulus, s.center.stimulus);
    EXPECT_NE(same.section, s.center.section);
    if (s.decoy == "none") {
      EXPECT_EQ(s.right.stimulus, s.center.stimulus);
      EXPECT_NE(s.right.section, s.center.section);
      EXPECT_NE(s.right.section, s.left.section);
    } else {
      const auto& decoy = s.decoy == "left" ? s.left : s.right;
      EXPECT_EQ(kStimuli[static_cast<std::size_t>(decoy.stimulus)].method, s.method);
      EXPECT_EQ(kStimuli[static_cast<std::size_t>(decoy.stimulus)].shape, s.shape);
      EXPECT_NE(decoy.section, s.center.section);
      EXPECT_NE(decoy.section, same.section);
    }
  }
  EXPECT_EQ(screens.size(), 160u);
  EXPECT_EQ(count["smooth/original/none"], 40);
  EXPECT_GT(count["smooth/csg/left"], 8);
  EXPECT_GT(count["smooth/csg/right"], 8);
}

using Images = std::set<std::pair<int, int>>;
Images images_of(const Screen& s) {
  return {{s.left.stimulus, s.left.section},
          {s.center.stimulus, s.center.section},
          {s.right.stimulus, s.right.section}};
}

TEST(ShapeStudy, TrainingRepeatsNoTestScreen) {
  const std::vector<Stimulus> stimuli{
      {"smooth", "original", 5}, {"smooth", "csg", 5}, {"complex", "original", 5}, {"complex", "csg", 5}};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto screens = make_screens(stimuli, 4, seed);
    const auto training = make_training(stimuli, screens, 10, seed);
    ASSERT_EQ(training.size(), 10u);
    std::set<Images> test, practice;
    for (const auto& s : screens) test.insert(images_of(s));
    std::set<std::string> kinds;
    for (const auto& s : training) {
      EXPECT_EQ(test.count(images_of(s)), 0u);
      EXPECT_TRUE(practice.insert(images_of(s)).second);
      EXPECT_EQ(images_of(s).size(), 3u);
      kinds.insert(s.shape + "/" + s.method);
    }
    EXPECT_EQ(kinds.size(), 4u);
  }
}

// Three sections make one set of three, which the test screen shows.
TEST(ShapeStudy, TrainingFailsIfNoScreensAreLeft) {
  const std::vector<Stimulus> stimuli{{"a", "original", 3}};
  const auto screens = make_screens(stimuli, 1, 1);
  EXPECT_TRUE(make_training(stimuli, screens, 0, 1).empty());
  EXPECT_EQ(test::code_of([&] { make_training(stimuli, screens, 1, 1); }), "too-few-sections");
}

TEST(ShapeStudy, ThePageTellsNothing) {
  const auto screens = make_screens(kStimuli, 2, 1);
  std::vector<std::vector<std::string>> names;
  int n = 0;
  for (const auto& s : kStimuli) {
    names.emplace_back();
    for (int i = 0; i < s.sections; ++i) names.back().push_back(std::to_string(++n) + ".png");
  }
  const auto training = make_training(kStimuli, screens, 5, 1);
  const auto page = page_of(screens, training, names);
  for (const char* word : {"csg", "smooth", "complex", "decoy", "http"})
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  EXPECT_EQ(key_of(screens, names).rows.size(), screens.size());
  // Every screen of the test and of the training is listed once.
  std::size_t listed = 0;
  for (auto at = page.find(".png\"],"); at != std::string::npos; at = page.find(".png\"],", at + 1)) ++listed;
  EXPECT_EQ(listed, screens.size() + training.size());
}

TEST(ShapeStudy, WritesAFolder) {
  const Value stack = Value::of(Image(8, 8, 4, 1, Vec3f::Ones()));
  const auto folder = test::temporary_folder();
  const auto run =
      test::run_node("ShapeStudy", {{"images", stack}, {"images", stack}},
                     {{"path", "study"}, {"names", "[a/original, a/csg]"}, {"training", "5"}}, folder);
  EXPECT_EQ(run.metrics.at("screens"), 8);
  for (const char* file :
       {"study/index.html", "study/key.csv", "study/images/001.png", "study/images/006.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  std::ifstream in(folder / "study/key.csv");
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "screen,shape,method,decoy,left,center,right");
}

// Without fit, the study is the paper's: 80 screens, a fifth of them without a decoy.
TEST(ShapeStudy, ShowsTheChosenMethodsOnly) {
  const Value stack = Value::of(Image(8, 8, 4, 1, Vec3f::Ones()));
  const auto folder = test::temporary_folder();
  const auto run = test::run_node(
      "ShapeStudy", {{"images", stack}, {"images", stack}, {"images", stack}},
      {{"path", "study"}, {"names", "[a/original, a/csg, a/fit]"}, {"methods", "[csg]"}, {"training", "0"}},
      folder);
  EXPECT_EQ(run.metrics.at("screens"), 8);
  EXPECT_EQ(run.metrics.at("pictures"), 8);
  for (const auto& row : run.output<Table>("key").rows) EXPECT_NE(std::get<std::string>(row[2]), "fit");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("ShapeStudy", {{"images", stack}},
                             {{"path", "s"}, {"names", "[a/original]"}, {"methods", "[cgs]"}},
                             test::temporary_folder());
            }),
            "unknown-method");
}

TEST(ShapeStudy, BadInputIsNamed) {
  EXPECT_EQ(test::code_of([] { make_screens({{"a", "csg", 3}}, 1, 1); }), "no-original");
  EXPECT_EQ(test::code_of([] {
              make_screens({{"a", "original", 3}, {"a", "csg", 2}}, 1, 1);
            }),
            "too-few-sections");
  EXPECT_EQ(test::code_of([] { make_screens({{"a", "original", 2}}, 1, 1); }), "no-original");
  const Value stack = Value::of(Image(8, 8, 3, 1, Vec3f::Ones()));
  for (const char* names : {"[a]", "[a/b, c/d]", "[/b]"})
    EXPECT_EQ(test::code_of([&] {
                test::run_node("ShapeStudy", {{"images", stack}}, {{"path", "s"}, {"names", names}},
                               test::temporary_folder());
              }),
              "bad-names");
}

}  // namespace
}  // namespace terrazzo
