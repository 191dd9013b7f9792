#include "nodes/shapes/load_mesh/read_mesh.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

// Upper bound of memory per byte of file: a triangle has at least 4 bytes in a binary PLY file, and up to 104
// bytes in memory while the list of faces grows.
constexpr double kBytesPerByte = 30;

using MeshReader = PolygonSoup (*)(std::string_view, const Reading&, TextureCoordinates);

MeshReader format_of(const std::filesystem::path& path) {
  const std::string extension = lowercase(path.extension().string());
  if (extension == ".obj")
    return [](std::string_view text, const Reading&, TextureCoordinates uv) { return read_obj(text, uv); };
  if (extension == ".ply")
    return [](std::string_view text, const Reading&, TextureCoordinates) { return read_ply(text); };
  if (extension == ".stl")
    return [](std::string_view bytes, const Reading& reading, TextureCoordinates) {
      return read_stl(bytes, reading);
    };
  if (extension == ".off")
    return [](std::string_view text, const Reading&, TextureCoordinates) { return read_off(text); };
  if (extension == ".glb" || extension == ".gltf") return read_gltf;
  throw Error("unknown-format",
              fmt::format("{}: unknown mesh file extension \"{}\"", path.filename().string(), extension),
              "use an .obj, .ply, .stl, .off, .glb or .gltf file");
}

PolygonSoup read_named(const std::filesystem::path& path, MeshReader format, std::string_view content,
                       const Reading& reading, TextureCoordinates uv) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (content.starts_with(kByteOrderMark)) content.remove_prefix(kByteOrderMark.size());
  Reading named = reading;
  named.warn = [&](const std::string& message) { reading.warn(path.filename().string() + ": " + message); };
  try {
    return format(content, named, uv);
  } catch (const Error& e) {
    throw Error(e.diagnostic().code, path.filename().string() + ": " + e.diagnostic().message,
                e.diagnostic().hint);
  }
}

}  // namespace

PolygonSoup read_mesh(const std::filesystem::path& path, const Reading& reading, TextureCoordinates uv) {
  const std::string name = path.filename().string();
  const MeshReader format = format_of(path);
  std::string content;
  try {
    content = read_whole(path, reading);
  } catch (const Error& e) {
    if (e.diagnostic().code == "too-large") throw;
    throw Error("unreadable-mesh", name + ": cannot be opened", "check the file's permissions");
  }
  require_memory(kBytesPerByte * content.size(), reading.memory, "the mesh of " + name);
  const PolygonSoup soup = read_named(path, format, content, reading, uv);
  if (soup.polygons.empty())
    throw Error("unreadable-mesh", name + ": contains no faces",
                "check that the file is complete and that its extension matches its format");
  const int n = soup.vertices.size();
  for (std::size_t f = 0; f < soup.polygons.size(); ++f)
    for (const int v : soup.polygons[f])
      if (v < 0 || v >= n)
        throw Error("bad-mesh", fmt::format("{}: face {} refers to vertex {} of {}", name, f, v, n),
                    "the file is damaged: export it again");
  for (int v = 0; v < n; ++v)
    if (!soup.vertices[v].allFinite())
      throw Error("bad-mesh", fmt::format("{}: vertex {} is not finite", name, v),
                  "the file is damaged: export it again");
  return soup;
}

}  // namespace terrazzo::load_mesh
