// Classes of pixels by example: a random forest that learns from strokes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "runtime/work.h"

namespace terrazzo {

// Pixels of a section that show one class.
struct TaughtClass {
  int number = 0;
  std::vector<std::uint32_t> pixels;
};

// The pixels under strokes, sorted and unique. `strokes` may be null.
std::vector<std::uint32_t> stroked_pixels(const Strokes* strokes, int width, int height);

// Features are color, gradient, Laplacian, and eigenvalues of the Hessian and of the structure tensor at four
// scales (as in ilastik; Berg et al. 2019), learned by 60 trees (Breiman 2001). Up to 400 bytes per
// pixel of a section, with four threads.
class PixelForest {
 public:
  // Classes without a pixel are not learned; at least one has some.
  PixelForest(const Image&, int section, const std::vector<TaughtClass>&, std::uint64_t seed, const Work&);
  ~PixelForest();
  // The share of the trees that say each of the classes 0 … classes − 1, of each pixel of a section.
  std::vector<std::vector<float>> classify(const Image&, int section, int classes, const Work&) const;

 private:
  struct Forest;
  std::unique_ptr<Forest> forest_;
};

}  // namespace terrazzo
