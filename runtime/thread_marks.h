// TBB's own library carries no ThreadSanitizer instrumentation: the sanitizer does not see that a task comes
// after what spawned it, nor the end of a loop after its tasks. These marks tell it; elsewhere they are
// nothing.
#pragma once

#ifdef __SANITIZE_THREAD__
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#endif

namespace terrazzo {

class ThreadMark {
 public:
  // What this thread did so far is done before whatever follows an after() on the same mark.
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
