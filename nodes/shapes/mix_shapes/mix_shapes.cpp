#include "nodes/shapes/mix_shapes/mix_shapes.h"

#include <cmath>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/shape_measures.h"

namespace terrazzo::mix_shapes {

Shapes mix(const std::vector<const Shapes*>& sets, const std::vector<double>& shares) {
  if (shares.size() != sets.size())
    throw Error("wrong-count",
                fmt::format("there are {} shares for {} sets of shapes", shares.size(), sets.size()),
                "set one share per set")
        .parameter("shares");
  Shapes out;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (!(shares[i] >= 0) || !std::isfinite(shares[i]))
      throw Error("bad-probabilities", fmt::format("share {} must be 0 or more; it is {}", i + 1, shares[i]),
                  "correct the share")
          .parameter("shares");
    Shapes set = *sets[i];
    normalize_probabilities(set);
    for (Shape& s : set.shapes) {
      s.probability *= shares[i];
      out.shapes.push_back(std::move(s));
    }
  }
  normalize_probabilities(out);
  return out;
}

}  // namespace terrazzo::mix_shapes
