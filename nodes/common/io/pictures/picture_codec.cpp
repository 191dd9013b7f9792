#include "nodes/common/io/pictures/picture_codec.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "runtime/memory.h"
#include "runtime/plugin.h"

namespace terrazzo {

const PictureCodec& picture_codec() {
  // Address space that the libraries need, including the allocations of their constructors.
  constexpr std::uint64_t kRoom = 260'000'000;
  static const PictureCodec& loaded = []() -> const PictureCodec& {
    if (const std::uint64_t left = available_address_space(); left < kRoom)
      throw Error("no-memory",
                  fmt::format("not enough address space to load OpenImageIO: {} MB left, but {} MB needed",
                              left / 1'000'000, kRoom / 1'000'000),
                  "raise the limit (ulimit -v)");
    const auto file = library_folder() / TERRAZZO_PICTURE_MODULE;
    void* handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) throw Error("program", ::dlerror(), "reinstall Terrazzo and its dependencies");
    const auto get =
        reinterpret_cast<decltype(&terrazzo_picture_codec)>(::dlsym(handle, "terrazzo_picture_codec"));
    if (!get)
      throw Error("program", ::dlerror(),
                  "reinstall Terrazzo: '" + file.string() + "' has a different version");
    return *get();
  }();
  return loaded;
}

}  // namespace terrazzo
