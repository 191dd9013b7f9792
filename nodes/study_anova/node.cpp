#include <fmt/format.h>

#include <cmath>
#include <map>

#include "graph/node_type.h"
#include "nodes/common/io/reading.h"
#include "nodes/common/plot/plot.h"
#include "nodes/study_anova/anova.h"
#include "nodes/study_anova/answers.h"
#include "runtime/context.h"

namespace terrazzo {

namespace {

using study_anova::Answer;

struct Cell {
  double fooled = 0, seconds = 0;
  int n = 0, asked = 0;
};

void add_effects(Table& t, const std::string& of, const std::vector<double>& value,
                 const std::vector<std::string>& method, const std::vector<std::string>& shape) {
  for (const auto& e : study_anova::two_way(value, method, shape))
    t.rows.push_back({of, e.name, e.squares, e.freedom,
                      std::isnan(e.f) ? Table::Cell(std::string()) : Table::Cell(e.f),
                      std::isnan(e.p) ? Table::Cell(std::string()) : Table::Cell(e.p)});
}

void compute(Context& c) {
  const auto& key_file = c.files("key").front();
  const auto key = study_anova::read_key(read_whole(key_file, reading_of(c)), key_file.string());
  std::vector<Answer> answers;
  for (const auto& file : c.files("answers")) {
    const auto some = study_anova::read_answers(read_whole(file, reading_of(c)), file.string(), key);
    answers.insert(answers.end(), some.begin(), some.end());
  }
  if (answers.empty())
    throw Error("no-answers", "the files contain no answers", "run the study first").parameter("answers");
  std::vector<double> fooled, seconds;
  std::vector<std::string> method, shape, timed_method, timed_shape;
  std::map<std::string, Cell> by_method;
  for (const Answer& a : answers) {
    Cell& cell = by_method[a.method];
    cell.seconds += a.seconds, ++cell.asked;
    seconds.push_back(std::log(std::max(a.seconds, 0.05)));
    timed_method.push_back(a.method), timed_shape.push_back(a.shape);
    if (a.decoy == "none") continue;
    const double wrong = a.choice != a.decoy;
    cell.fooled += wrong, ++cell.n;
    fooled.push_back(wrong), method.push_back(a.method), shape.push_back(a.shape);
  }
  Table t;
  t.columns = {"quantity", "effect", "sum of squares", "degrees of freedom", "F", "p"};
  if (!fooled.empty()) add_effects(t, "fooled", fooled, method, shape);
  add_effects(t, "log seconds", seconds, timed_method, timed_shape);
  Table summary;
  summary.columns = {"method", "answers", "fooled %", "standard error %", "seconds"};
  Plot plot;
  plot.title = "how often each decoy was taken for the original";
  plot.y_label = "%";
  PlotSeries bars;
  bars.kind = PlotSeries::Kind::Bars;
  for (const auto& [name, cell] : by_method) {
    const double share = cell.n ? cell.fooled / cell.n : 0.5;  // no decoys: chance
    const double error = cell.n ? std::sqrt(share * (1 - share) / cell.n) : 0;
    summary.rows.push_back(
        {name, static_cast<double>(cell.asked), 100 * share, 100 * error, cell.seconds / cell.asked});
    bars.x.push_back(static_cast<double>(plot.x_words.size()));
    plot.x_words.push_back(name);
    bars.y.push_back(100 * share), bars.low.push_back(100 * (share - error)),
        bars.high.push_back(100 * (share + error));
  }
  plot.series.push_back(std::move(bars));
  c.metric("answers", static_cast<double>(answers.size()));
  c.output("table", std::move(t));
  c.output("summary", std::move(summary));
  c.output("figure", draw(plot));
}

}  // namespace

NodeType study_anova_node() {
  return NodeType("StudyAnova", 2)
      .doc_(
          "Evaluates the answers of ShapeStudy: how often each method's decoys were taken for the original, "
          "how long people looked, and, by analysis of variance, whether method, shape or their interaction "
          "matters.")
      .source_("Jagnow, Dorsey, Rushmeier 2008, section 4.2.3")
      .output("table", "Table", "Effects on being fooled and on the logarithm of seconds, with F and p")
      .output("summary", "Table",
              "One row per method. `original` stands for screens without a decoy, where 50 % is chance.")
      .output("figure", "Image", "Bar chart as in figure 16 of the paper")
      .parameter(Parameter::input_path("answers").doc_(
          "File answers.csv of one session, or a glob for several sessions"))
      .parameter(Parameter::input_path("key").doc_("File key.csv of the study"))
      .compute_(compute);
}

}  // namespace terrazzo
