// Readers of the single formats. Each takes a file's content and throws Error "unreadable-mesh" or
// "bad-mesh"; read_mesh validates the result and adds the file name.
#pragma once

#include <string_view>

#include "nodes/shapes/load_mesh/read_mesh.h"

namespace terrazzo::load_mesh {

PolygonSoup read_obj(std::string_view, TextureCoordinates);
PolygonSoup read_off(std::string_view);
// With triangle strips.
PolygonSoup read_ply(std::string_view);
// Text or binary. Equal positions become one vertex. Warns about bytes behind the last triangle.
PolygonSoup read_stl(std::string_view, const Reading&);
// glTF 2.0, text or binary: all triangles of the default scene. Lengths become mm, and the z axis points up.
// Reads no other file. Also throws "too-large".
PolygonSoup read_gltf(std::string_view, const Reading&, TextureCoordinates);

}  // namespace terrazzo::load_mesh
