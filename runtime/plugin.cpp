#include "runtime/plugin.h"

#include "runtime/trust.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

void load(const fs::path& file, Registry& registry, ValueTypes& types) {
  // A plugin runs with this user's rights, so nobody else may be able to change it.
  if (const std::string why = who_else_may_write(file); !why.empty())
    throw Error("plugin", "the plugin '" + file.string() + "' is not loaded: " + why,
                "keep plugins in a folder that only you can write to (chmod go-w)");
  // Never closed, because node types point into it.
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw Error("plugin", ::dlerror());
  const auto version = reinterpret_cast<int (*)()>(::dlsym(library, "terrazzo_plugin_interface"));
  const auto add = reinterpret_cast<void (*)(Registry&, ValueTypes&)>(::dlsym(library, "terrazzo_plugin"));
  if (!version || !add)
    throw Error("plugin", "'" + file.string() + "' is not a plugin", "it must contain TERRAZZO_PLUGIN");
  if (version() != kPluginInterface)
    throw Error("plugin",
                "'" + file.string() + "' was built for plugin interface " + std::to_string(version()) +
                    ", but this program has " + std::to_string(kPluginInterface),
                "rebuild the plugin");
  add(registry, types);
}

}  // namespace

Diagnostics load_plugins(const std::string& path_list, Registry& registry, ValueTypes& types) {
  Diagnostics found;
  std::vector<fs::path> files;
  for (std::size_t at = 0; at < path_list.size();) {
    const auto colon = std::min(path_list.find(':', at), path_list.size());
    const fs::path entry = path_list.substr(at, colon - at);
    at = colon + 1;
    if (entry.empty()) continue;
    std::error_code error;
    if (!fs::is_directory(entry, error)) {
      files.push_back(entry);
      continue;
    }
    std::vector<fs::path> inside;
    for (const auto& e : fs::directory_iterator(entry, error))
      if (e.path().extension() == ".so") inside.push_back(e.path());
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  for (const auto& file : files) try {
      load(fs::absolute(file), registry, types);
    } catch (const Error& e) {
      found.push_back(e.diagnostic());
    }
  return found;
}

fs::path library_folder() {
  static const int here = 0;  // a variable, because a function's address may be that of a stub in the caller
  Dl_info found;
  if (!::dladdr(&here, &found)) throw Error("program", "cannot find the folder of Terrazzo's libraries");
  return fs::canonical(found.dli_fname).parent_path();
}

}  // namespace terrazzo
