// Readers of the single formats. Each takes a file's content and throws Error "unreadable-mesh" or
// "bad-mesh"; read_mesh validates the result and adds the file name.
#pragma once

#include <string_view>

#include "nodes/load_mesh/read_mesh.h"

namespace terrazzo::load_mesh {

PolygonSoup read_obj(std::string_view);
PolygonSoup read_off(std::string_view);
PolygonSoup read_ply(std::string_view);
PolygonSoup read_stl(std::string_view);

}  // namespace terrazzo::load_mesh
