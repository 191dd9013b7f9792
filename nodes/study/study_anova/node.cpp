#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/io/text_input.h"
#include "nodes/study/study_anova/answers.h"
#include "nodes/study/study_anova/report.h"
#include "runtime/context.h"

namespace terrazzo::study_anova {
namespace {

void compute(Context& c) {
  const auto& key_file = c.files("key").front();
  const auto key = read_key(read_text(key_file, reading_of(c)), key_file.string());
  std::vector<Answer> answers;
  std::size_t number = 0;
  for (const auto& file : c.files("answers")) {
    ++number;
    for (Answer& a : read_answers(read_text(file, reading_of(c)), file.string(), key)) {
      // Each session writes one file, and many people leave the suggested name unchanged.
      a.participant = fmt::format("{}/{}", number, a.participant);
      answers.push_back(std::move(a));
    }
  }
  if (answers.empty())
    throw Error("no-answers", "the files contain no answers", "run the study first").parameter("answers");
  const auto design = design_of(key);
  std::vector<std::string> notes;
  c.output("table", effects(answers, design, notes));
  for (const auto& note : notes) c.warn(note);
  c.metric("answers", answers.size());
  c.output("summary", by_method(answers, design));
  c.output("by_shape", by_shape(answers, design));
  c.output("figure", figure_by_method(answers, design));
  c.output("figure_by_shape", figure_by_shape(answers, design));
}

}  // namespace
}  // namespace terrazzo::study_anova

namespace terrazzo {

NodeType study_anova_node() {
  using namespace study_anova;
  return NodeType("StudyAnova", 3)
      .doc_(
          "Evaluates the answers of ShapeStudy: how often each method's decoys were mistaken for the "
          "original, how long people looked, and, by analysis of variance, whether method, shape or their "
          "interaction matters.")
      .source_(
          "Jagnow, Dorsey, Rushmeier 2008, section 4.2.3, figures 16 and 17; Greenhouse and Geisser 1959")
      .output(
          "table", "Table",
          "Effects of method and shape on being fooled, on seconds and on their logarithm, on the screens "
          "with a decoy. one-way and two-way treat all answers as independent; repeated measures compares "
          "each effect with its variation between people, and corrects p by ε.")
      .output("summary", "Table",
              "One row per method: mean and standard deviation over people, and their difference. `original` "
              "stands for screens without a decoy, where 50 % is chance.")
      .output("by_shape", "Table", "The same for each shape and method")
      .output("figure", "Image",
              "Figure 16 of the paper: decoys mistaken for originals, and seconds, by method. Whiskers are "
              "standard deviations over people.")
      .output("figure_by_shape", "Image", "Figure 17 of the paper: the same by shape and method")
      .parameter(Parameter::input_path("answers").doc_(
          "File answers.csv of one session, or a glob for several sessions. Participants of different files "
          "are different people, even if they have one name."))
      .parameter(Parameter::input_path("key").doc_("File key.csv of the study"))
      .compute_(compute);
}

}  // namespace terrazzo
