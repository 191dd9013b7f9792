// Rasters that must belong to the same picture.
#pragma once

#include <string>

#include "graph/diagnostic.h"

namespace terrazzo {

// Throws Error "size-mismatch" unless both have the same width, height and number of sections. The names
// include the verb: "the labels have", "the image has".
template <class A, class B>
void require_equal_size(const A& a, const std::string& a_has, const B& b, const std::string& b_has,
                        const std::string& hint) {
  if (a.width == b.width && a.height == b.height && a.sections == b.sections) return;
  const auto size = [](const auto& r) {
    return std::to_string(r.width) + " × " + std::to_string(r.height) + " pixels in " +
           std::to_string(r.sections) + " sections";
  };
  throw Error("size-mismatch", a_has + " " + size(a) + ", but " + b_has + " " + size(b), hint);
}

}  // namespace terrazzo
