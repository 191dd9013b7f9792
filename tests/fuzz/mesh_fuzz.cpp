// Fuzzes mesh files in each format, and mesh repair. The first byte selects the format.
#include <unistd.h>

#include <fstream>

#include "nodes/shapes/load_mesh/read_mesh.h"
#include "nodes/shapes/load_mesh/repair.h"

using namespace terrazzo;
using namespace load_mesh;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const char* const formats[] = {".off", ".obj", ".ply", ".stl", ".glb", ".gltf"};
  if (size == 0) return 0;
  const std::string file =
      (std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(::getpid()))).string() +
      formats[data[0] % 6];
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  try {
    Mesh mesh = triangles_of(read_mesh(file));
    weld(mesh, 0);
    if (mesh.triangles.size() < 500) repair(mesh);
  } catch (const Error&) {
  }
  ::unlink(file.c_str());
  return 0;
}
