// Means of the answers of each person, and their spread over people.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "nodes/study/study_anova/answers.h"

namespace terrazzo::study_anova {

// What is averaged: 1 if the decoy was taken for the original and 0 otherwise, or a time.
enum class Quantity { Fooled, Seconds, LogSeconds };

// NaN for Fooled on a screen without a decoy.
double value_of(const Answer&, Quantity);

// Mean and sample standard deviation over people of the mean of each person's answers.
struct Spread {
  int people = 0, answers = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();  // NaN without people
  double sd = std::numeric_limits<double>::quiet_NaN();    // NaN with fewer than two people
};

// Answers to screens of this method and shape; "" stands for all.
Spread spread_of(const std::vector<Answer>&, const std::string& method, const std::string& shape, Quantity);

// Mean of each person (row) for each combination of method and shape (column: method · shapes + shape), for
// the people with answers to all combinations. `left_out` counts the others.
struct PeopleMeans {
  std::vector<std::vector<double>> rows;
  int left_out = 0;
};
PeopleMeans means_by_person(const std::vector<Answer>&, const std::vector<std::string>& methods,
                            const std::vector<std::string>& shapes, Quantity);

}  // namespace terrazzo::study_anova
