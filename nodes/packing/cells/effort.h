// The work of filling space, counted and never timed, so that the result depends on neither the machine nor
// the number of threads.
#pragma once

namespace terrazzo::tessellation {

// Unit: about a nanosecond of one core. Loops that could go on for long
// end with what they have once the effort is spent; each still takes its first step.
struct Effort {
  double limit = 1e300;
  double used = 0;
  bool spent() const { return used > limit; }
};

}  // namespace terrazzo::tessellation
