// One picture over another.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::blend {

enum class Mode { Mix, Multiply, Screen, Overlay, Add, Subtract, Difference };

// Where the upper picture shows. At most one is given.
struct Mask {
  const Image* image = nullptr;    // its brightness, 0 to 1
  const Labels* labels = nullptr;  // on particles
};

// Blends scene-linear values. All have the size of `below`, and as many sections or one. Throws Error
// "empty-image", "size-mismatch".
Image blend_images(const Image& below, const Image& over, const Mask&, Mode, double amount, const Work&);

}  // namespace terrazzo::blend
