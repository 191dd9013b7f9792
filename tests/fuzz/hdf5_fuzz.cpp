// Fuzzes HDF5 files: groups, datasets and attributes, and the layout of DREAM3D.
#include <unistd.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/common/io/hdf5/hdf5_input.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/dream3d.h"

using namespace terrazzo;

namespace {

// Reads everything below a group.
void read_all(const Hdf5Input& file, Hdf5Input::Address at, int depth) {
  Hdf5Array array;
  std::string bytes;
  for (const char* name : {"TupleDimensions", "ObjectType", "x"}) try {
      file.attribute(at, name, array, bytes);
    } catch (const Error&) {
    }
  if (depth == 0) return;
  if (file.is_group(at)) {
    for (const auto& [name, child] : file.children(at)) try {
        read_all(file, child, depth - 1);
      } catch (const Error&) {
      }
  } else if (const Hdf5Array a = file.array(at); a.count() < (1u << 24) / a.bytes) {
    file.read(at);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string content(reinterpret_cast<const char*>(data), size);
  try {
    const Hdf5Input file(content);
    read_all(file, file.root(), 4);
  } catch (const Error&) {
  }
  const std::string path =
      (std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(::getpid()))).string() + ".dream3d";
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(size));
  Reading reading;
  reading.memory = 500'000'000;
  try {
    load_volume::read_dream3d(path, "", {}, reading);
  } catch (const Error&) {
  }
  ::unlink(path.c_str());
  return 0;
}
