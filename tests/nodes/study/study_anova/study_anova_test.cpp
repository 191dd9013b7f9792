#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <tuple>

#include "nodes/study/study_anova/answers.h"
#include "nodes/study/study_anova/people.h"
#include "nodes/study/study_anova/report.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace study_anova;

Answer answer(const std::string& person, const std::string& shape, const std::string& method, bool fooled,
              double seconds) {
  return {person, shape, method, method == "original" ? "none" : "left", fooled ? "right" : "left", seconds};
}

// Three people; `csg` fools them in 1 of 2, 0 of 2 and 2 of 4 answers.
std::vector<Answer> few_answers() {
  std::vector<Answer> out;
  for (const auto& [person, fooled, right] : {std::tuple{"a", 1, 1}, {"b", 0, 2}, {"c", 2, 2}}) {
    for (int i = 0; i < fooled; ++i) out.push_back(answer(person, "smooth", "csg", true, 2));
    for (int i = 0; i < right; ++i) out.push_back(answer(person, "smooth", "csg", false, 4));
    out.push_back(answer(person, "smooth", "original", false, 8));
  }
  return out;
}

// The mean over people weights everyone alike, however many answers they gave; its spread is the sample
// standard deviation of 0.5, 0 and 0.5.
TEST(StudyAnova, SpreadIsThatOverPeople) {
  const auto answers = few_answers();
  const Spread s = spread_of(answers, "csg", "", Quantity::Fooled);
  EXPECT_EQ(s.people, 3);
  EXPECT_EQ(s.answers, 8);
  EXPECT_NEAR(s.mean, 1.0 / 3, 1e-12);
  EXPECT_NEAR(s.sd, std::sqrt(1.0 / 12), 1e-12);
  const Spread t = spread_of(answers, "csg", "smooth", Quantity::Seconds);  // 3, 4 and 3 s
  EXPECT_NEAR(t.mean, 10.0 / 3, 1e-12);
  EXPECT_NEAR(t.sd, std::sqrt(1.0 / 3), 1e-12);
  EXPECT_EQ(spread_of(answers, "original", "", Quantity::Fooled).people, 0);
  EXPECT_TRUE(std::isnan(spread_of({answers[0]}, "csg", "", Quantity::Fooled).sd));
}

TEST(StudyAnova, OneRowPerMethodAndPerShape) {
  const Design design{{"csg", "fit"}, {"smooth", "complex"}};
  auto answers = few_answers();
  for (const char* person : {"a", "b", "c"})
    for (const char* shape : {"smooth", "complex"}) answers.push_back(answer(person, shape, "fit", true, 1));
  const Table t = by_method(answers, design);
  ASSERT_EQ(t.rows.size(), 3u);
  EXPECT_EQ(std::get<std::string>(t.rows[0][0]), "original");
  EXPECT_EQ(t.number(0, "fooled %"), 50);
  EXPECT_EQ(t.number(0, "seconds"), 8);
  EXPECT_NEAR(t.number(1, "mean − sd %"), 100 / 3.0 - 100 * std::sqrt(1.0 / 12), 1e-9);
  EXPECT_EQ(t.number(2, "mean − sd %"), 100);
  EXPECT_EQ(t.number(1, "shapes with the highest mean − sd"), 0);
  EXPECT_EQ(t.number(2, "shapes with the highest mean − sd"), 2);
  const Table shapes = by_shape(answers, design);
  ASSERT_EQ(shapes.rows.size(), 6u);
  EXPECT_EQ(shapes.number(1, "answers"), 8);
  EXPECT_EQ(shapes.number(4, "people"), 0);  // complex, csg
  EXPECT_EQ(std::get<std::string>(shapes.rows[4][4]), "");
}

// People differ more than methods: with repeated measures, an effect shows that is lost among single answers.
TEST(StudyAnova, RepeatedMeasuresSeparatePeople) {
  std::vector<Answer> answers;
  for (int person = 0; person < 6; ++person)
    for (const char* shape : {"smooth", "complex"})
      for (const char* method : {"csg", "fit"})
        for (int k = 0; k < 4; ++k)
          answers.push_back(answer(std::to_string(person), shape, method, (person + k) % 2 == 0,
                                   1 + 3 * person + (method[0] == 'f') + 0.1 * ((person * k) % 3)));
  const Design design{{"csg", "fit"}, {"smooth", "complex"}};
  std::vector<std::string> notes;
  const Table t = effects(answers, design, notes);
  EXPECT_TRUE(notes.empty());
  double one_way = -1, repeated = -1;
  for (std::size_t i = 0; i < t.rows.size(); ++i) {
    const auto word = [&](int c) { return std::get<std::string>(t.rows[i][static_cast<std::size_t>(c)]); };
    if (word(0) != "seconds" || word(2) != "method") continue;
    if (word(1) == "one-way") one_way = t.number(i, "p");
    if (word(1) == "repeated measures") repeated = t.number(i, "corrected p");
  }
  EXPECT_GT(one_way, 0.2);
  EXPECT_LT(repeated, 1e-6);

  // People who did not answer everything are left out, and their number is reported.
  answers.push_back(answer("late", "smooth", "csg", true, 1));
  effects(answers, design, notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("1 of 7 people"), std::string::npos) << notes[0];
  notes.clear();
  effects({answer("late", "smooth", "csg", true, 1)}, design, notes);
  EXPECT_FALSE(notes.empty());
}

// Two sessions under the suggested name are two people.
TEST(StudyAnova, EachFileIsAnotherSession) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "key.csv")
      << "screen,shape,method,decoy\n1,smooth,csg,left\n2,smooth,original,none\n";
  for (const char* name : {"first.csv", "second.csv"})
    std::ofstream(folder / name) << "participant,screen,choice,seconds\n1,1,left,2\n1,2,left,3\n";
  const auto run = test::run_node("StudyAnova", {},
                                  {{"answers", "'" + (folder / "*d.csv").string() + "'"},
                                   {"key", "'" + (folder / "key.csv").string() + "'"}});
  EXPECT_EQ(run.output<Table>("summary").number(0, "people"), 1);
  const auto both = test::run_node("StudyAnova", {},
                                   {{"answers", "'" + (folder / "[fs]*.csv").string() + "'"},
                                    {"key", "'" + (folder / "key.csv").string() + "'"}});
  EXPECT_EQ(both.output<Table>("summary").number(0, "people"), 2);
}

TEST(StudyAnova, FilesAreReadByTheirColumns) {
  const auto key =
      read_key("screen,shape,method,decoy\n1,smooth,csg,left\n2,smooth,original,none\n", "key.csv");
  const auto a =
      read_answers("screen,participant,seconds,choice\n1,7,2.5,right\n\n2,7,1,left\n", "a.csv", key);
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a[0].method, "csg");
  EXPECT_EQ(a[0].choice, "right");
  EXPECT_EQ(a[0].seconds, 2.5);
  const std::string header = "participant,screen,choice,seconds\n";
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,9,left,1\n", "a", key); }), "no-such-screen");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1,up,1\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1,left,soon\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1,left,2,3\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1.5,left,2\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers("", "a", key); }), "no-column");
}

}  // namespace
}  // namespace terrazzo
