#include "nodes/compare/texture_observer/observer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "nodes/compare/texture_observer/filter_features.h"
#include "nodes/compare/texture_observer/pattern_features.h"
#include "nodes/compare/texture_observer/ridge.h"

namespace terrazzo::texture_observer {

namespace {

// What is learned from one half of both classes, and judged in the other.
struct Trial {
  std::array<CropRows, 2> learn, judge;
  int judged_half = 0;
};

enum class CellColor { Any, Even, Odd };

CropRows rows_of(const CropSet& set, CellColor color, bool judged) {
  CropRows out{&set, {}};
  for (std::size_t i = 0; i < set.crops.size(); ++i) {
    const bool odd = set.cells[set.crops[i].cell].odd;
    if ((color == CellColor::Any || odd == (color == CellColor::Odd)) && (!judged || set.crops[i].judged))
      out.rows.push_back(i);
  }
  return out;
}

void balance(std::array<CropRows, 2>& classes) {
  const std::size_t n = std::min(classes[0].rows.size(), classes[1].rows.size());
  for (auto& c : classes) c.rows.resize(n);  // cells are in random order
}

std::array<Trial, 2> trials_of(const std::array<const Halves*, 2>& pictures,
                               const std::array<CellColor, 2>& colors) {
  std::array<Trial, 2> trials;
  for (int half = 0; half < 2; ++half) {
    for (int k = 0; k < 2; ++k) {
      trials[half].learn[k] = rows_of((*pictures[k])[half], colors[k], false);
      trials[half].judge[k] = rows_of((*pictures[k])[1 - half], colors[k], true);
    }
    trials[half].judged_half = 1 - half;
    balance(trials[half].learn);
    balance(trials[half].judge);
  }
  return trials;
}

// Features of every crop of a set.
using FeatureTable = std::map<const CropSet*, Eigen::MatrixXd>;

// The rows of both classes, class 0 first.
struct Examples {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
  std::vector<int> strip;
};

Examples examples_of(const std::array<CropRows, 2>& classes, const FeatureTable& features) {
  const Eigen::Index n = classes[0].rows.size();
  Examples out{Eigen::MatrixXd(2 * n, features.at(classes[0].set).cols()), Eigen::VectorXd(2 * n), {}};
  for (int k = 0; k < 2; ++k)
    for (Eigen::Index i = 0; i < n; ++i) {
      const int row = classes[k].rows[i];
      out.x.row(k * n + i) = features.at(classes[k].set).row(row);
      out.y[k * n + i] = 2 * k - 1;
      out.strip.push_back(classes[k].set->cells[classes[k].set->crops[row].cell].strip);
    }
  return out;
}

// Both trials of one observer on one pair of classes.
struct Exam {
  std::array<Trial, 2> trials;
  std::array<Examples, 2> learn, judge;
};

std::vector<JudgedCrop> judged_by(const Exam& exam, const FeatureGroup& group, const Work& work) {
  std::vector<JudgedCrop> out;
  for (int t = 0; t < 2; ++t) {
    const Examples& learn = exam.learn[t];
    const Ridge ridge(learn.x.middleCols(group.first, group.count), learn.y, learn.strip, work);
    const Eigen::VectorXd scores = ridge.scores(exam.judge[t].x.middleCols(group.first, group.count));
    Eigen::Index i = 0;
    for (int k = 0; k < 2; ++k)
      for (int row : exam.trials[t].judge[k].rows)
        out.push_back({k == 1, exam.trials[t].judged_half, row, scores[i++]});
  }
  return out;
}

Accuracy accuracy_of(const std::vector<JudgedCrop>& judged, const Exam& exam) {
  const auto recognized = [](const JudgedCrop& j) {
    return j.score == 0 ? 0.5 : (j.score > 0) == j.of_b ? 1.0 : 0.0;
  };
  Accuracy out;
  out.crops = judged.size();
  const double n = judged.size();
  out.share = 0;
  for (const auto& j : judged) out.share += recognized(j);
  out.share /= n;
  // Neighboring crops may show one particle or one gradient of light, so sums over cells and over strips vary
  // more than those of independent crops.
  std::map<std::tuple<bool, int, int>, double> cells, strips;
  for (const auto& j : judged) {
    const CropSet& set = *exam.trials[1 - j.half].judge[j.of_b].set;
    const int cell = set.crops[j.crop].cell;
    const double above = recognized(j) - out.share;
    cells[{j.of_b, j.half, cell}] += above;
    strips[{j.of_b, j.half, set.cells[cell].strip}] += above;
  }
  double variance = std::max(out.share * (1 - out.share), 0.25 / n) / n;
  for (const auto* sums : {&cells, &strips}) {
    double square = 0;
    for (const auto& [part, sum] : *sums) square += sum * sum;
    variance = std::max(variance, square / (n * n));
  }
  out.error = std::sqrt(variance);
  return out;
}

}  // namespace

const GroupAccuracy* Verdict::giveaway() const {
  const GroupAccuracy* best = nullptr;
  for (const auto& g : groups)
    if (g.accuracy.share > 0.5 + 3 * g.accuracy.error && (!best || g.accuracy.share > best->accuracy.share))
      best = &g;
  return best;
}

std::array<Verdict, 2> observe(const Halves& a, const Halves& b, std::uint64_t seed, const Work& work) {
  std::array<Verdict, 2> verdicts;
  verdicts[0].observer = "patterns";
  verdicts[1].observer = "features";
  const std::array<const std::vector<FeatureGroup>*, 2> groups{&pattern_groups(), &filter_groups()};
  FeatureTable patterns;
  for (const Halves* picture : {&a, &b})
    for (const CropSet& half : *picture)
      patterns[&half] =
          pattern_features(half, work.part(0.05 * patterns.size(), 0.05 * patterns.size() + 0.05));
  const std::array<std::array<Trial, 2>, 2> trials{trials_of({&a, &b}, {CellColor::Any, CellColor::Any}),
                                                   trials_of({&a, &a}, {CellColor::Even, CellColor::Odd})};
  std::array<std::array<Exam, 2>, 2> exams;  // [observer][main, control]
  for (int control = 0; control < 2; ++control) {
    for (int t = 0; t < 2; ++t) {
      const Trial& trial = trials[control][t];
      const double start = 0.2 + 0.15 * (2 * control + t);
      const FilterBank bank = learn_filters(trial.learn, seed);
      FeatureTable filtered;
      for (const auto* classes : {&trial.learn, &trial.judge})
        for (const CropRows& c : *classes)
          if (!filtered.count(c.set))
            filtered[c.set] = filter_features(*c.set, bank, work.part(start, start + 0.15).quiet());
      for (int o = 0; o < 2; ++o) {
        Exam& exam = exams[o][control];
        exam.trials = trials[control];
        exam.learn[t] = examples_of(trial.learn, o ? filtered : patterns);
        exam.judge[t] = examples_of(trial.judge, o ? filtered : patterns);
      }
      work.progress(start + 0.15);
    }
  }
  // The fits, the longest first: all features with and without control, then the groups alone.
  struct Fit {
    int observer;
    bool control;
    FeatureGroup group;
    std::vector<JudgedCrop> judged;
  };
  std::vector<Fit> fits;
  for (int o : {1, 0}) {
    const FeatureGroup all{"", 0, groups[o]->back().first + groups[o]->back().count};
    fits.push_back({o, false, all, {}});
    fits.push_back({o, true, all, {}});
  }
  for (int o = 0; o < 2; ++o)
    for (const FeatureGroup& group : *groups[o]) fits.push_back({o, false, group, {}});
  work.part(0.8, 1).parallel(fits.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      fits[i].judged = judged_by(exams[fits[i].observer][fits[i].control], fits[i].group, work);
  });
  for (Fit& fit : fits) {
    Verdict& v = verdicts[fit.observer];
    const Accuracy accuracy = accuracy_of(fit.judged, exams[fit.observer][fit.control]);
    if (!fit.group.name.empty())
      v.groups.push_back({fit.group.name, accuracy});
    else if (fit.control)
      v.control = accuracy;
    else {
      v.accuracy = accuracy;
      v.judged = std::move(fit.judged);
    }
  }
  return verdicts;
}

}  // namespace terrazzo::texture_observer
