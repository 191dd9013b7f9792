#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>

#include "runtime/cli/command_line.h"
#include "runtime/plugin.h"
#include "runtime/studio/library.h"
#include "runtime/studio/paint_options.h"

namespace {

template <bool with_plugins>
const terrazzo::NodeSet& nodes() {
  static const terrazzo::NodeSet all = [] {
    const terrazzo::studio::Library& library = terrazzo::studio::library();
    terrazzo::NodeSet set;
    library.register_nodes(set.registry);
    library.register_value_types(set.types);
    set.read_provenance = library.read_provenance;
    if (const char* plugins = std::getenv("TERRAZZO_PLUGIN_PATH"); plugins && with_plugins)
      for (const auto& d : terrazzo::load_plugins(plugins, set.registry, set.types))
        std::cerr << d.text() << '\n';
    return set;
  }();
  return all;
}

}  // namespace

namespace {

// Most of what needs memory before main() runs are the libraries' own constructors. Nothing can catch what they
// throw, and some end the program themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their own start comes later

constexpr rlim_t kRoomToStart = 96'000'000;

[[noreturn]] void end_without_room() {
  constexpr char message[] = "error: not enough address space to start: raise the limit (ulimit -v)\n";
  [[maybe_unused]] const auto n = ::write(STDERR_FILENO, message, sizeof message - 1);
  ::_exit(1);
}

std::terminate_handler usual_end;

void end_or_say_why() {
  try {
    if (const auto e = std::current_exception()) std::rethrow_exception(e);
  } catch (const std::bad_alloc&) {
    end_without_room();
  } catch (const std::system_error& e) {  // a thread whose stack finds no room
    if (e.code() == std::errc::resource_unavailable_try_again) end_without_room();
  } catch (...) {
  }
  usual_end();
}

void before_libraries() {
  usual_end = std::set_terminate(end_or_say_why);
  struct rlimit limit;
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  char text[64] = {};  // pages in use, and more
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  const auto read = ::read(file, text, sizeof text - 1);
  ::close(file);
  const rlim_t used = std::strtoull(text, nullptr, 10) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
  if (read > 0 && used + kRoomToStart > limit.rlim_cur) end_without_room();
}

// Called before the constructors of every library.
[[gnu::section(".preinit_array"), gnu::used]] void (*const call_before_libraries)() = before_libraries;

#endif

}  // namespace

int main(int argc, char** argv) {
  return terrazzo::run_command_line(argc, argv, {nodes<true>, nodes<false>, terrazzo::studio::add_paint});
}
