#include "nodes/properties/homogenize/bounds.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::homogenize {
namespace {

// The mean of the values as resistances in series with `add`: (Σ f / (v + add))⁻¹ − add.
double mean_with(const std::vector<double>& fraction, const std::vector<double>& values, double add) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (fraction[i] == 0) continue;
    if (values[i] + add == 0) return 0;
    sum += fraction[i] / (values[i] + add);
  }
  return 1 / sum - add;
}

// Smallest and largest of the values that occur.
Bounds range_of(const std::vector<double>& fraction, const std::vector<double>& values) {
  Bounds out{INFINITY, 0};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (fraction[i] > 0) out = {std::min(out.low, values[i]), std::max(out.high, values[i])};
  return out;
}

}  // namespace

Bounds wiener_bounds(const std::vector<double>& fraction, const std::vector<double>& values) {
  Bounds out{mean_with(fraction, values, 0), 0};
  for (std::size_t i = 0; i < values.size(); ++i) out.high += fraction[i] * values[i];
  return out;
}

Bounds hashin_shtrikman(const std::vector<double>& fraction, const std::vector<double>& values) {
  const Bounds range = range_of(fraction, values);
  return {mean_with(fraction, values, 2 * range.low), mean_with(fraction, values, 2 * range.high)};
}

ElasticBounds hashin_shtrikman(const std::vector<double>& fraction, const std::vector<Elastic>& values) {
  std::vector<double> bulk, shear;
  for (const Elastic& v : values) {
    bulk.push_back(v.lambda() + 2 * v.mu() / 3);
    shear.push_back(v.mu());
  }
  const Bounds k = range_of(fraction, bulk), g = range_of(fraction, shear);
  const auto stiffened = [](double bulk_of, double shear_of) {
    return shear_of > 0 ? shear_of / 6 * (9 * bulk_of + 8 * shear_of) / (bulk_of + 2 * shear_of) : 0;
  };
  ElasticBounds out;
  out.bulk = {mean_with(fraction, bulk, 4 * g.low / 3), mean_with(fraction, bulk, 4 * g.high / 3)};
  out.shear = {mean_with(fraction, shear, stiffened(k.low, g.low)),
               mean_with(fraction, shear, stiffened(k.high, g.high))};
  return out;
}

Moduli isotropic_part(const Stiffness& c) {
  const double normal = c(0, 0) + c(1, 1) + c(2, 2), cross = c(0, 1) + c(0, 2) + c(1, 2);
  return {(normal + 2 * cross) / 9, (normal - cross + 3 * (c(3, 3) + c(4, 4) + c(5, 5))) / 15};
}

}  // namespace terrazzo::homogenize
