// Encoding of the classes of shapes, after everything else and only if any shape has one, so that values
// without classes keep their content hashes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "runtime/codec.h"

namespace terrazzo {

// `Element` has a member int cls, −1 without a class.
// `always`: something else follows.
template <class Element>
void encode_classes(const std::vector<Element>& elements, Writer& w, bool always = false) {
  if (!always && std::all_of(elements.begin(), elements.end(), [](const auto& e) { return e.cls < 0; }))
    return;
  std::vector<std::int32_t> classes;
  for (const auto& e : elements) classes.push_back(e.cls);
  w.array(classes);
}

// Reads what encode_classes() wrote at the end of the stream. Throws Error "damaged".
template <class Element>
void decode_classes(std::vector<Element>& elements, Reader& r) {
  if (r.left() == 0) return;
  const auto classes = r.array<std::int32_t>();
  if (classes.size() != elements.size()) throw Error("damaged", "the stored classes are not one per shape");
  for (std::size_t i = 0; i < elements.size(); ++i) elements[i].cls = classes[i];
}

}  // namespace terrazzo
