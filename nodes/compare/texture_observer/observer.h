// Classifiers that try to tell crops of two pictures apart.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/compare/texture_observer/crops.h"
#include "runtime/work.h"

namespace terrazzo::texture_observer {

struct Accuracy {
  double share = 0.5;  // of the crops that were recognized, 0 … 1; 0.5 is chance
  double error = 0.5;  // its standard error; crops of a cell or strip may be dependent
  int crops = 0;       // judged, of both classes
};

struct JudgedCrop {
  bool of_b = false;  // which picture it is from
  int half = 0;       // which half of it
  int crop = 0;       // index into the crops of that half
  double score = 0;   // positive: taken for b; about ±1 if the observer is certain
};

struct GroupAccuracy {
  std::string name;
  Accuracy accuracy;  // with this group of features alone
};

struct Verdict {
  std::string observer;  // "patterns" or "features"
  Accuracy accuracy;
  Accuracy control;  // of a's cells, one color of a checkerboard against the other
  std::vector<GroupAccuracy> groups;
  std::vector<JudgedCrop> judged;

  // The group that recognizes most, or null if none exceeds chance by three standard errors.
  const GroupAccuracy* giveaway() const;
};

using Halves = std::array<CropSet, 2>;

// Both observers, `patterns` first. Each learns from one half of both pictures and judges the other half,
// then vice versa. Both classes have equally many crops. The controls depend on `a` and the seed only.
std::array<Verdict, 2> observe(const Halves& a, const Halves& b, std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::texture_observer
