#include "nodes/common/geometry/grid/grid_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/voxel_source.h"

namespace terrazzo {

std::string grid_to_read(const Volume& volume, const std::string& name,
                         const std::vector<std::string>& usual) {
  const auto all = grid_names(volume);
  const auto has = [&](const std::string& n) { return std::find(all.begin(), all.end(), n) != all.end(); };
  if (!name.empty()) {
    if (has(name)) return name;
    throw Error("no-such-grid",
                fmt::format("the volume has no grid '{}' (its grids: {})", name, fmt::join(all, ", ")),
                "choose one of them")
        .parameter("grid");
  }
  for (const std::string& n : usual)
    if (has(n)) return n;
  if (all.size() == 1) return all[0];
  throw Error("several-grids",
              fmt::format("the volume has none of the grids {} (its grids: {})", fmt::join(usual, ", "),
                          fmt::join(all, ", ")),
              "name one of them with grid")
      .parameter("grid");
}

}  // namespace terrazzo
