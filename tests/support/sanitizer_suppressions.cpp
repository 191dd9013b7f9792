// What the sanitizers must not report, in every program built with them.
#ifdef __SANITIZE_THREAD__
// Tasks are handed over within TBB, whose headers are compiled here and whose library is not
// (runtime/thread_marks.h). The others are libraries built without the sanitizer; swrast_dri is Mesa's
// software renderer with threads of its own.
extern "C" const char* __tsan_default_suppressions() {
  return "race_top:task_ptr_or_nullptr\n"
         "race_top:tbb::detail\n"
         "race:libembree\n"
         "race:libopenvdb\n"
         "race:libOpenImageIO\n"
         "race:libtbb\n"
         "race:swrast_dri\n";
}
#endif
#ifdef __SANITIZE_ADDRESS__
// OpenImageIO keeps its plug-ins' tables to the end.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO\n"; }
#endif
