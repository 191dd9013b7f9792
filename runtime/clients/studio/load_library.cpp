// Part of the program itself, not of the library that it loads.
#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <exception>
#include <new>
#include <system_error>

#include "graph/diagnostic.h"
#include "runtime/clients/studio/library.h"
#include "runtime/memory.h"
#include "runtime/plugin.h"

namespace terrazzo::studio {

namespace {

// Address space that the libraries need, including the allocations of their constructors.
constexpr std::uint64_t kRoom = 320'000'000;

// A terminate handler, because exceptions thrown by the libraries' constructors cannot be caught.
std::terminate_handler usual_end;
[[noreturn]] void end_or_say_why() {
  const auto end_without_room = [] {
    constexpr char kMessage[] =
        "error: not enough address space to load the node types: raise the limit (ulimit -v)\n";
    [[maybe_unused]] const auto n = ::write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
    ::_exit(1);
  };
  const auto thrown = std::current_exception();
  if (!thrown && available_address_space() < kRoom)
    end_without_room();  // a library called terminate() itself
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    end_without_room();
  } catch (const std::system_error& e) {  // no room for a thread's stack
    if (e.code() == std::errc::resource_unavailable_try_again) end_without_room();
  } catch (...) {
  }
  usual_end();
  ::_exit(1);
}

}  // namespace

const Library& library() {
  static const Library& loaded = []() -> const Library& {
    if (const std::uint64_t left = available_address_space(); left < kRoom)
      throw Error("no-memory",
                  fmt::format("not enough address space to load the node types: {} MB left, but {} MB needed",
                              left / 1'000'000, kRoom / 1'000'000),
                  "raise the limit (ulimit -v)");
    usual_end = std::set_terminate(end_or_say_why);
    const auto file = library_folder() / TERRAZZO_STUDIO_LIBRARY;
    // RTLD_GLOBAL, so that plugins can use the symbols of the nodes as if the program were linked to them.
    void* handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (!handle) throw Error("program", ::dlerror(), "reinstall Terrazzo and its dependencies");
    const auto get =
        reinterpret_cast<decltype(&terrazzo_studio_library)>(::dlsym(handle, "terrazzo_studio_library"));
    if (!get)
      throw Error("program", ::dlerror(),
                  "reinstall Terrazzo: '" + file.string() + "' has a different version");
    return *get();
  }();
  return loaded;
}

}  // namespace terrazzo::studio
