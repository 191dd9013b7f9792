// The readers of single formats, from a file's content. Each throws Error "unreadable-mesh"; read_mesh checks
// what they give and names the file.
#pragma once

#include <string_view>

#include "nodes/load_mesh/read_mesh.h"

namespace terrazzo::mesh_files {

PolygonSoup read_obj(std::string_view);
PolygonSoup read_off(std::string_view);
PolygonSoup read_ply(std::string_view);
PolygonSoup read_stl(std::string_view);

}  // namespace terrazzo::mesh_files
