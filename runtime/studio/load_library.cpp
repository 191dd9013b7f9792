// Belongs to the program itself, not to the library that it loads.
#include <dlfcn.h>

#include "graph/diagnostic.h"
#include "runtime/plugin.h"
#include "runtime/studio/library.h"

namespace terrazzo::studio {

#ifdef TERRAZZO_STUDIO_LIBRARY  // its file name, where it is a shared library

const Library& library() {
  static const Library& loaded = []() -> const Library& {
    const auto file = library_folder() / TERRAZZO_STUDIO_LIBRARY;
    // Its symbols are global, so that plugins find those of the nodes as if the program were linked to them.
    void* handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (!handle) throw Error("program", ::dlerror(), "install Terrazzo and the libraries that it uses again");
    const auto get =
        reinterpret_cast<decltype(&terrazzo_studio_library)>(::dlsym(handle, "terrazzo_studio_library"));
    if (!get)
      throw Error("program", ::dlerror(),
                  "install Terrazzo again: '" + file.string() + "' is another version");
    return *get();
  }();
  return loaded;
}

#else

const Library& library() { return *terrazzo_studio_library(); }

#endif

}  // namespace terrazzo::studio
