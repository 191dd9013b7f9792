#include "nodes/study/study_anova/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/plot/plot.h"
#include "nodes/common/statistics/anova.h"
#include "nodes/data/indices.h"
#include "nodes/study/study_anova/people.h"

namespace terrazzo::study_anova {

namespace {

const std::string kOriginal = "original";
const AnovaFactors kFactors{"method", "shape"};

Table::Cell cell_of(double v, double scale = 1) {
  return std::isnan(v) ? Table::Cell(std::string()) : Table::Cell(scale * v);
}

// The share of answers that took the decoy for the original. Without a decoy it is half by chance.
Spread fooled(const std::vector<Answer>& answers, const std::string& method, const std::string& shape) {
  if (method != kOriginal) return spread_of(answers, method, shape, Quantity::Fooled);
  Spread chance;
  chance.mean = 0.5;
  return chance;
}

// Methods with answers, "original" first.
std::vector<std::string> shown_methods(const std::vector<Answer>& answers, const Design& design) {
  std::vector<std::string> all{kOriginal}, out;
  all.insert(all.end(), design.methods.begin(), design.methods.end());
  for (const auto& m : all)
    if (std::any_of(answers.begin(), answers.end(), [&](const Answer& a) { return a.method == m; }))
      out.push_back(m);
  return out;
}

std::vector<Table::Cell> numbers(const std::vector<Answer>& answers, const std::string& method,
                                 const std::string& shape) {
  const Spread f = fooled(answers, method, shape), s = spread_of(answers, method, shape, Quantity::Seconds);
  return {static_cast<double>(s.people),
          static_cast<double>(s.answers),
          cell_of(f.mean, 100),
          cell_of(f.sd, 100),
          cell_of(f.mean - f.sd, 100),
          cell_of(s.mean),
          cell_of(s.sd)};
}

const std::vector<std::string> kNumbers{"people",      "answers", "fooled %",  "sd %",
                                        "mean − sd %", "seconds", "seconds sd"};

Plot chart(const std::vector<Answer>& answers, const Design& design, const std::vector<std::string>& shapes,
           Quantity quantity) {
  const bool share = quantity == Quantity::Fooled;
  Plot plot;
  plot.title = share ? "decoys taken for originals" : "time per answer";
  plot.y_label = share ? "%" : "s";
  for (const auto& shape : shapes) plot.x_words.push_back(shape.empty() ? "all shapes" : shape);
  int color = 0;
  for (const auto& method : shown_methods(answers, design)) {
    PlotSeries bars;
    bars.kind = PlotSeries::Kind::Bars;
    bars.name = method == kOriginal ? "no decoy" : method;
    bars.color = color++;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const Spread s =
          share ? fooled(answers, method, shapes[k]) : spread_of(answers, method, shapes[k], quantity);
      const double scale = share ? 100 : 1;
      bars.x.push_back(k);
      bars.y.push_back(scale * s.mean);
      bars.low.push_back(scale * (s.mean - s.sd));
      bars.high.push_back(scale * (s.mean + s.sd));
    }
    plot.series.push_back(std::move(bars));
  }
  return plot;
}

Image charts(const std::vector<Answer>& answers, const Design& design,
             const std::vector<std::string>& shapes) {
  return draw(
      {chart(answers, design, shapes, Quantity::Fooled), chart(answers, design, shapes, Quantity::Seconds)},
      2);
}

void add_rows(Table& t, const std::string& quantity, const std::string& analysis,
              const std::vector<AnovaEffect>& effects, bool repeated) {
  for (const auto& e : effects)
    t.rows.push_back({quantity, analysis, e.name, e.squares, e.freedom, e.error_squares, e.error_freedom,
                      cell_of(e.f), cell_of(e.p), repeated ? cell_of(e.epsilon) : Table::Cell(std::string()),
                      repeated ? cell_of(e.corrected_p) : Table::Cell(std::string())});
}

}  // namespace

Design design_of(const std::map<int, KeyEntry>& key) {
  Design out;
  const auto add = [](std::vector<std::string>& to, const std::string& name) {
    if (std::find(to.begin(), to.end(), name) == to.end()) to.push_back(name);
  };
  for (const auto& [screen, entry] : key) {
    if (entry.method != kOriginal) add(out.methods, entry.method);
    add(out.shapes, entry.shape);
  }
  return out;
}

Table effects(const std::vector<Answer>& answers, const Design& design, std::vector<std::string>& notes) {
  Table t;
  t.columns = {"quantity",
               "analysis",
               "effect",
               "sum of squares",
               "degrees of freedom",
               "error sum of squares",
               "error degrees of freedom",
               "F",
               "p",
               "epsilon",
               "corrected p"};
  const std::vector<std::pair<std::string, Quantity>> quantities{
      {"fooled", Quantity::Fooled}, {"seconds", Quantity::Seconds}, {"log seconds", Quantity::LogSeconds}};
  std::vector<Answer> decoys;
  std::copy_if(answers.begin(), answers.end(), std::back_inserter(decoys),
               [](const Answer& a) { return a.decoy != "none"; });
  if (decoys.empty()) {
    notes.push_back("there are no answers to screens with a decoy, so there is no analysis of variance");
    return t;
  }
  for (const auto& [name, quantity] : quantities) {
    std::vector<double> value;
    std::vector<std::string> method, shape;
    for (const Answer& a : decoys) {
      value.push_back(value_of(a, quantity));
      method.push_back(a.method);
      shape.push_back(a.shape);
    }
    const auto cells = anova_cells(value, method, shape);
    add_rows(t, name, "one-way", one_way_anova(cells, kFactors), false);
    const auto two_way = two_way_anova(cells, kFactors);
    add_rows(t, name, "two-way", two_way, false);
    if (quantity == Quantity::Fooled && !two_way.empty() && two_way[0].error_freedom < 1)
      notes.push_back(
          fmt::format("{} answers to {} combinations of method and shape are too few for a two-way analysis",
                      decoys.size(), cells.size()));
    const PeopleMeans means = means_by_person(decoys, design.methods, design.shapes, quantity);
    if (means.rows.size() < 2) {
      if (quantity == Quantity::Fooled)
        notes.push_back(fmt::format(
            "repeated measures need two or more people with answers to every method and shape; there {} {}",
            means.rows.size() == 1 ? "is" : "are", means.rows.size()));
      continue;
    }
    if (means.left_out && quantity == Quantity::Fooled)
      notes.push_back(fmt::format(
          "repeated measures leave out {} of {} people, who have no answer to some method and shape",
          means.left_out, means.left_out + count_of(means.rows)));
    Eigen::MatrixXd values(means.rows.size(), means.rows[0].size());
    for (std::size_t i = 0; i < means.rows.size(); ++i)
      for (std::size_t j = 0; j < means.rows[i].size(); ++j) values(i, j) = means.rows[i][j];
    add_rows(t, name, "repeated measures",
             repeated_anova(values, design.methods.size(), design.shapes.size(), kFactors), true);
  }
  return t;
}

Table by_method(const std::vector<Answer>& answers, const Design& design) {
  std::map<std::string, double> best;
  for (const auto& shape : design.shapes) {
    std::map<std::string, double> floors;
    for (const auto& method : design.methods) {
      const Spread s = fooled(answers, method, shape);
      if (s.people >= 2) floors[method] = s.mean - s.sd;
    }
    double highest = -std::numeric_limits<double>::infinity();
    for (const auto& [method, value] : floors) highest = std::max(highest, value);
    for (const auto& [method, value] : floors) best[method] += value >= highest - 1e-12;
  }
  Table t;
  t.columns = {"method"};
  t.columns.insert(t.columns.end(), kNumbers.begin(), kNumbers.end());
  t.columns.push_back("shapes with the highest mean − sd");
  for (const auto& method : shown_methods(answers, design)) {
    std::vector<Table::Cell> row{method};
    for (auto& c : numbers(answers, method, "")) row.push_back(std::move(c));
    row.push_back(method == kOriginal ? Table::Cell(std::string()) : Table::Cell(best[method]));
    t.rows.push_back(std::move(row));
  }
  return t;
}

Table by_shape(const std::vector<Answer>& answers, const Design& design) {
  Table t;
  t.columns = {"shape", "method"};
  t.columns.insert(t.columns.end(), kNumbers.begin(), kNumbers.end());
  for (const auto& shape : design.shapes)
    for (const auto& method : shown_methods(answers, design)) {
      std::vector<Table::Cell> row{shape, method};
      for (auto& c : numbers(answers, method, shape)) row.push_back(std::move(c));
      t.rows.push_back(std::move(row));
    }
  return t;
}

Image figure_by_method(const std::vector<Answer>& answers, const Design& design) {
  return charts(answers, design, {""});
}

Image figure_by_shape(const std::vector<Answer>& answers, const Design& design) {
  return charts(answers, design, design.shapes);
}

}  // namespace terrazzo::study_anova
