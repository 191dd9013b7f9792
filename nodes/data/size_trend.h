// How the share of a shape among all shapes depends on the particles' size.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "runtime/codec.h"

namespace terrazzo {

// Relative to other shapes, a shape's probability grows with this power of the size; it holds at `size`. Of
// a shape that was traced from a stone of this size, it also falls off on both sides, as
// (1 + (ln(at / size) / spread)²)⁻³: slowly, so that sizes beyond those of all stones get the nearest ones.
struct SizeTrend {
  double power = 0;
  double size = 1;    // mm
  double spread = 0;  // of the logarithm of the size; 0: any size

  bool even() const { return power == 0 && spread == 0; }
  double factor(double at) const {
    const double steps = spread > 0 ? std::log(at / size) / spread : 0;
    const double near = 1 + steps * steps;
    return (power == 0 ? 1 : std::pow(at / size, power)) / (near * near * near);
  }
};

// `Element` has a member SizeTrend trend.
template <class Element>
bool have_trend(const std::vector<Element>& elements) {
  return std::any_of(elements.begin(), elements.end(), [](const Element& e) { return !e.trend.even(); });
}

template <class Element>
void encode_trends(const std::vector<Element>& elements, Writer& w) {
  for (const Element& e : elements) {
    w.pod(e.trend.power);
    w.pod(e.trend.size);
    w.pod(e.trend.spread);
  }
}

// Throws Error "damaged".
template <class Element>
void decode_trends(std::vector<Element>& elements, Reader& r) {
  for (Element& e : elements) {
    e.trend.power = r.pod<double>();
    e.trend.size = r.pod<double>();
    e.trend.spread = r.pod<double>();
    if (!std::isfinite(e.trend.power) || !(e.trend.size > 0) || !std::isfinite(e.trend.size) ||
        !(e.trend.spread >= 0) || !std::isfinite(e.trend.spread))
      throw Error("damaged", "a stored shape has an invalid trend");
  }
}

}  // namespace terrazzo
