// Tables and figures of a study's answers.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/study/study_anova/answers.h"

namespace terrazzo::study_anova {

// Methods and shapes in the order of their first screens. `methods` excludes "original", the screens without
// a decoy.
struct Design {
  std::vector<std::string> methods, shapes;
};
Design design_of(const std::map<int, KeyEntry>&);

// Analyses of variance of being fooled, of seconds and of the logarithm of seconds, on the screens with a
// decoy. Analyses: one-way (method) and two-way, of single answers as if they were independent, and repeated
// measures, of the means of people with answers to every method and shape. `notes` receives what could not be
// analyzed.
Table effects(const std::vector<Answer>&, const Design&, std::vector<std::string>& notes);

// One row per method, "original" first if it was timed: mean and standard deviation over people of how often
// the decoy was taken for the original (50 % for "original", which is chance) and of the seconds. Cells
// without a value are empty texts. "shapes with the highest mean − sd" counts the shapes for which no other
// method's mean minus standard deviation is higher.
Table by_method(const std::vector<Answer>&, const Design&);

// The same for each shape and method, without that count.
Table by_shape(const std::vector<Answer>&, const Design&);

// Jagnow et al. 2008, figures 16 and 17: how often decoys were taken for originals, and the seconds; bars are
// means over people, and whiskers one standard deviation.
Image figure_by_method(const std::vector<Answer>&, const Design&);
Image figure_by_shape(const std::vector<Answer>&, const Design&);

}  // namespace terrazzo::study_anova
