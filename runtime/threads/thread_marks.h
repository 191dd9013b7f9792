// The TBB library is built without ThreadSanitizer instrumentation, so the sanitizer does not see that a task
// runs after the code that spawned it, or that a loop ends after its tasks. These marks declare that order.
// Without the sanitizer, they do nothing.
#pragma once

#ifdef __SANITIZE_THREAD__
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#endif

namespace terrazzo {

class ThreadMark {
 public:
  // Everything that this thread did before before() happens before the code that follows an after() on the
  // same mark.
  void before() {
#ifdef __SANITIZE_THREAD__
    __tsan_release(this);
#endif
  }
  void after() {
#ifdef __SANITIZE_THREAD__
    __tsan_acquire(this);
#endif
  }
};

}  // namespace terrazzo
