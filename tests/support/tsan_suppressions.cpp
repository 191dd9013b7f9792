// What ThreadSanitizer must not report, in every program built with it: tasks are handed over within TBB,
// whose headers are compiled here and whose library is not (runtime/thread_marks.h).
#ifdef __SANITIZE_THREAD__
extern "C" const char* __tsan_default_suppressions() {
  return "race_top:task_ptr_or_nullptr\n"
         "race_top:tbb::detail\n"
         "race:libopenvdb\n"
         "race:libOpenImageIO\n"
         "race:libtbb\n";
}
#endif
