#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "nodes/photograph/edit_labels/edit_labels.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace edit_labels;

// Three squares of 8 × 8 pixels in a row, the first two touching: 1 at x 2…9, 2 at 10…17, 3 at 22…29.
Labels squares(int sections = 1) {
  Labels l;
  l.width = 32;
  l.height = 12;
  l.sections = sections;
  l.ids.assign(static_cast<std::size_t>(32) * 12 * sections, 0);
  for (int s = 0; s < sections; ++s)
    for (int y = 2; y < 10; ++y)
      for (int x = 2; x < 30; ++x)
        if (const int id = x < 10 ? 1 : x < 18 ? 2 : x < 22 ? 0 : 3) l.ids[l.index(x, y, s)] = id + 3 * s;
  for (int s = 0; s < sections; ++s) l.classes.insert(l.classes.end(), {5, 6, 7});
  return l;
}

Edited edited(const Labels& labels, const std::vector<std::string>& texts) {
  std::vector<Edit> edits;
  for (const auto& t : texts) edits.push_back(read_edit(t));
  return apply_edits(labels, edits, {});
}
std::ptrdiff_t pixels_of(const Labels& l, int id) { return std::count(l.ids.begin(), l.ids.end(), id); }

TEST(EditLabels, MergeJoinsAndKeepsTheFirstClass) {
  const Edited e = edited(squares(), {"merge 12 5 4 4"});
  EXPECT_TRUE(e.warnings.empty());
  EXPECT_EQ(e.labels.classes, (std::vector<std::int32_t>{6, 7}));
  EXPECT_EQ(pixels_of(e.labels, 1), 128);
  EXPECT_EQ(pixels_of(e.labels, 2), 64);
}

TEST(EditLabels, SplitDividesOneParticleAndLosesNoPixel) {
  for (const char* line :
       {"split 5.5 -3 5.5 40", "split 0 0 12 12", "split 1 6 6 6 6 20", "split 5.5 -1e6 5.5 1e6"}) {
    const Labels before = squares();
    const Edited e = edited(before, {line});
    EXPECT_TRUE(e.warnings.empty()) << line << ": " << (e.warnings.empty() ? "" : e.warnings[0]);
    ASSERT_EQ(e.labels.count(), 4) << line;
    for (std::size_t i = 0; i < before.ids.size(); ++i) EXPECT_EQ(before.ids[i] > 0, e.labels.ids[i] > 0);
    std::set<std::int32_t> of_first;
    for (std::size_t i = 0; i < before.ids.size(); ++i)
      if (before.ids[i] == 1) of_first.insert(e.labels.ids[i]);
    EXPECT_EQ(of_first.size(), 2u);
  }
}

TEST(EditLabels, MergeUndoesSplit) {
  const Labels before = squares();
  const Edited e = edited(before, {"split 5.5 0 5.5 11", "merge 3 5 8 5"});
  EXPECT_EQ(e.labels.ids, before.ids);
  EXPECT_EQ(e.labels.classes, before.classes);
}

TEST(EditLabels, DeleteOutlineIgnore) {
  Edited e = edited(squares(), {"delete 4 4 25 5", "outline 0 0 4 0 4 3 0 3", "ignore 10 0 14 12"});
  EXPECT_TRUE(e.warnings.empty());
  EXPECT_EQ(e.labels.count(), 2);
  EXPECT_EQ(pixels_of(e.labels, 1), 12);  // the outline comes first in reading order
  EXPECT_EQ(pixels_of(e.labels, 2), 32);  // half of the second square
  EXPECT_EQ(pixels_of(e.not_material, 1), 48);
  e = edited(squares(2), {"1: delete 4 4"});
  EXPECT_EQ(e.labels.count(), 5);
  EXPECT_EQ(pixels_of(e.labels, 1), 64);
}

TEST(EditLabels, WhatNoLongerAppliesIsAWarningAndTheRestIsDone) {
  for (const char* text :
       {"merge 4 4 20 5", "merge 4 4 5 5", "split 20 0 20 11", "split 2 3 4 3", "delete 0 0", "delete -5 1e9",
        "outline 100 100 110 100 110 110", "ignore -9 -9 -1 -1", "3: delete 4 4"}) {
    const Edited e = edited(squares(), {text, "delete 25 5"});
    ASSERT_EQ(e.warnings.size(), 1u) << text;
    EXPECT_NE(e.warnings[0].find("edit 1 no longer applies"), std::string::npos);
    EXPECT_EQ(e.labels.count(), 2) << text;
  }
}

TEST(EditLabels, NumbersFollowThePicture) {
  const Edited e = edited(squares(), {});
  EXPECT_EQ(e.labels.ids, squares().ids);
  Labels negative = squares();
  negative.ids[0] = -1;
  EXPECT_EQ(test::code_of([&] { edited(negative, {}); }), "bad-labels");
}

TEST(EditLabels, WhatCannotBeReadIsAnErrorAtItsLine) {
  for (const char* text : {"", "join 1 2 3 4", "merge 1 2", "merge 1 2 3", "delete", "outline 1 2 3 4",
                           "delete a b", "x: delete 1 2", "-1: delete 1 2", "delete nan 2", "delete inf 2"})
    EXPECT_EQ(test::code_of([&] { read_edit(text); }), "bad-value") << text;
  const auto file = test::temporary_folder() / "graph.yaml";
  std::ofstream(file)
      << "terrazzo: 1\nnodes:\n  labels: {type: LoadLabels, params: {path: "
      << (test::source_folder() / "graphs/samples/section_labels.png").string()
      << "}}\n  edit:\n    type: EditLabels\n    inputs: {labels: labels.labels}\n    params:\n      edits:\n"
      << "        - delete 10 10\n        - join 3 4 5 6\n";
  const auto run = test::run_program({"check", file.string()});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_NE(run.err.find("graph.yaml:10:"), std::string::npos) << run.err << run.out;
  EXPECT_NE((run.err + run.out).find("there is no edit 'join'"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
