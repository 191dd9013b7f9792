#include "nodes/export/outputs.h"

#include <fmt/format.h>

#include <algorithm>

namespace terrazzo::exporting {

void write_named(Context& c, const std::string& path,
                 const std::function<void(const std::filesystem::path&)>& write) {
  c.write_file(path, [&](const std::filesystem::path& file) {
    try {
      write(file);
    } catch (const Error& e) {
      const Diagnostic& d = e.diagnostic();
      if (d.code != "write-failed" && d.code != "unwritable-image") throw;
      std::string why = d.message;
      if (const auto at = why.find("': "); at != std::string::npos) why = why.substr(at + 3);
      throw Error("write-failed", "cannot write '" + path + "': " + why, d.hint).parameter("path");
    }
  });
}

Volume chosen_grids(const Context& c, const Volume& volume) {
  if (!c.keyword("grids").empty()) return volume;
  Volume out = volume;
  out.grids.clear();
  const auto all = grid_names(volume);
  for (const std::string& name : c.texts("grids")) {
    const auto at = std::find(all.begin(), all.end(), name);
    if (at == all.end())
      throw Error("no-such-grid",
                  fmt::format("the volume has no grid '{}' (its grids: {})", name, fmt::join(all, ", ")),
                  "choose one of them")
          .parameter("grids");
    out.grids.push_back(volume.grids[at - all.begin()]);
  }
  return out;
}

VoxelSource only_grid(const Context& c, const Volume& volume, const VoxelBox& box) {
  const auto all = grid_names(volume);
  std::vector<std::string> names =
      c.keyword("grids").empty() ? grid_names(chosen_grids(c, volume)) : std::vector<std::string>();
  if (names.empty() && std::find(all.begin(), all.end(), "id") != all.end()) names = {"id"};
  if (names.empty() && all.size() == 1) names = all;
  if (names.size() != 1)
    throw Error("several-grids",
                fmt::format("the file holds one grid; the volume has {}", fmt::join(all, ", ")),
                "name one of them with grids")
        .parameter("grids");
  return {volume, names[0], box};
}

}  // namespace terrazzo::exporting
