// Loops over long vectors, on all threads, with equal bits on any number of them.
#pragma once

#include <vector>

#include "runtime/work.h"

namespace terrazzo::homogenize {

constexpr std::size_t kVectorRange = 1 << 16;

// Calls f(i) for i = 0 … n − 1.
template <class F>
void each(std::size_t n, const Work& work, F&& f) {
  work.quiet().parallel(n, kVectorRange, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

template <class A>
double sum_of(const std::vector<A>& a, const Work& work) {
  return work.quiet().reduce<double>(
      a.size(), kVectorRange, 0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += a[i];
        return sum;
      },
      [](double p, double q) { return p + q; });
}

// Sums in double precision.
template <class A, class B>
double dot(const std::vector<A>& a, const std::vector<B>& b, const Work& work) {
  return work.quiet().reduce<double>(
      a.size(), kVectorRange, 0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(a[i]) * b[i];
        return sum;
      },
      [](double p, double q) { return p + q; });
}

}  // namespace terrazzo::homogenize
