// The floating-point environment and the locale of a thread that computes.
#pragma once

#include <locale.h>

#include <cfenv>

namespace terrazzo {

// While it exists, this thread rounds to nearest, keeps denormal numbers and raises no signals, and C
// libraries read and write numbers as in the locale "C", whatever the host program has set. So results do not
// depend on the host. The destructor restores what was set.
class NumericEnvironment {
 public:
  NumericEnvironment();
  ~NumericEnvironment();
  NumericEnvironment(const NumericEnvironment&) = delete;
  NumericEnvironment& operator=(const NumericEnvironment&) = delete;

 private:
  std::fenv_t floating_point_;
  locale_t locale_;
};

}  // namespace terrazzo
