// Code that runs without the GIL, and the end of the interpreter.
//
// When the interpreter ends, Python kills daemon threads that ask for the GIL, and a thread that is killed
// inside of C++ code takes the process with it. So end_all_runs() waits for the threads that are in such
// code, and afterwards no code releases the GIL any more. Use Outside in place of py::gil_scoped_release.
#pragma once

#include <optional>

#include "runtime/clients/python/bind.h"

namespace terrazzo::python {

// Whether the interpreter is exiting. Used with the GIL held.
bool exiting();

// The interpreter does not end as long as one exists that was made before it began to. Made and destroyed
// with the GIL held. `counted`: it is one of these, or inside of one.
struct InCode {
  InCode();
  ~InCode();
  InCode(const InCode&) = delete;
  InCode& operator=(const InCode&) = delete;
  const bool counted;
};

// Releases the GIL, unless the interpreter may end meanwhile.
class Outside {
 public:
  Outside() {
    if (in_code_.counted) without_gil_.emplace();
  }

 private:
  InCode in_code_;
  std::optional<py::gil_scoped_release> without_gil_;  // ends first
};

}  // namespace terrazzo::python
