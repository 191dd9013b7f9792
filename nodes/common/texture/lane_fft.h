// Fourier transforms of four signals in parallel, one in each lane of a vector register.
#pragma once

#include <cstddef>
#include <vector>

namespace terrazzo {

using Lane = float __attribute__((vector_size(16)));
struct LaneComplex {
  Lane re, im;
};

// Sizes with factors 2, 3 and 5 are fast; for other sizes the time is proportional to the largest prime
// factor. kissfft, the permissively licensed alternative to FFTW, supports neither batches nor vector types
// in its headers, and here thousands of slices are transformed.
class LaneFft {
 public:
  explicit LaneFft(int n);
  int size() const { return n_; }
  // In place and unnormalized, for `inner` interleaved transforms: element i of transform q is data[i·inner +
  // q]. `scratch` has as many elements as data.
  void run(LaneComplex* data, LaneComplex* scratch, int inner, bool inverse) const;

 private:
  struct Stage {
    int radix, m;                 // this pass combines `radix` parts of m elements
    std::vector<float> cos, sin;  // of 2π·p·k/(radix·m) at p·(radix − 1) + k − 1
  };
  int n_;
  std::vector<Stage> stages_;
  std::vector<float> root_cos_, root_sin_;  // of 2π·j/n, for radices above 5
};

// Transforms rows, then columns of data[y·width + x]. Unnormalized: a forward and an inverse transform
// together multiply by width·height.
class LaneFft2 {
 public:
  LaneFft2(int width, int height) : x_(width), y_(height) {}
  int width() const { return x_.size(); }
  int height() const { return y_.size(); }
  std::size_t count() const { return static_cast<std::size_t>(width()) * height(); }
  void run(LaneComplex* data, bool inverse, std::vector<LaneComplex>& scratch) const;

 private:
  LaneFft x_, y_;
};

// The largest number ≤ n, or the smallest even number ≥ n, without prime factors above 5. n ≥ 1.
int fast_size_below(int n);
int fast_even_size_above(int n);

}  // namespace terrazzo
