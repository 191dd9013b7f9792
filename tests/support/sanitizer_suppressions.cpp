// Sanitizer suppressions for every program built with sanitizers.
#ifdef __SANITIZE_THREAD__
// TBB hands over tasks between its headers, which are compiled here, and its library, which is not
// instrumented (runtime/threads/thread_marks.h). The others are libraries built without the sanitizer;
// swrast_dri is Mesa's multithreaded software renderer. When a thread has ended, glibc frees its thread-local
// storage of libraries that were loaded at run time, as the nodes are, while it makes the next thread; it
// knows by a lock of its own that the old one has run its destructors.
extern "C" const char* __tsan_default_suppressions() {
  return "race_top:task_ptr_or_nullptr\n"
         "race_top:tbb::detail\n"
         "race:libembree\n"
         "race:libopenvdb\n"
         "race:libOpenImageIO\n"
         "race:libOpenEXR\n"
         "race:libtbb\n"
         "race:swrast_dri\n"
         "race:_dl_deallocate_tls\n";
}
#endif
#ifdef __SANITIZE_ADDRESS__
// OpenImageIO never frees the tables of its plugins.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO\n"; }
#endif
