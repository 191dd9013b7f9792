// Returns the code of the error that a function throws.
#pragma once

#include <functional>
#include <string>

#include "graph/diagnostic.h"

namespace terrazzo::test {

// "" if it throws none.
inline std::string code_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.diagnostic().code;
  }
  return "";
}

}  // namespace terrazzo::test
