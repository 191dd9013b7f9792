#include "nodes/common/io/provenance.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/io/hdf5/hdf5_input.h"
#include "nodes/common/io/pictures/picture_input.h"
#include "nodes/common/io/provenance_text.h"
#include "nodes/common/io/reading.h"
#include "nodes/common/io/vdb_header.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace {

// glTF 2.0, 4.4: a header of 12 bytes, then the length and type of the JSON chunk.
std::string from_glb(const std::filesystem::path& path, const Reading& reading) {
  constexpr double kPerByte = 40;  // memory of parsed JSON per byte of text
  try {
    const std::string data = read_whole(path, reading);
    std::uint32_t length = 0;
    if (data.size() < 20 || data.compare(0, 4, "glTF") != 0) return "";
    std::memcpy(&length, data.data() + 12, sizeof length);
    if (length > data.size() - 20) return "";
    require_memory(kPerByte * length, reading.memory, "'" + path.string() + "'");
    const auto json = json_or_null(std::string_view(data).substr(20, length));
    const auto extras = nlohmann::json::json_pointer("/asset/extras");
    return json.is_object() && json.contains(extras) ? json_text(json.at(extras)) : "";
  } catch (const Error&) {
    return "";
  }
}

// The metadata is at the beginning of the file, before any grid.
std::string from_vdb(const std::filesystem::path& path, const Reading& reading) {
  try {
    const std::string content = read_whole(path, reading);
    const auto metadata = read_vdb_header(content).metadata;
    const auto it = metadata.find("provenance");
    return it != metadata.end() && it->second.type == "string" ? std::string(it->second.bytes) : "";
  } catch (const Error&) {
    return "";
  }
}

std::string from_dream3d(const std::filesystem::path& path, const Reading& reading) {
  try {
    const std::string content = read_whole(path, reading);
    const Hdf5Input file(content);
    const auto at = file.find("/Terrazzo/Provenance");
    if (at == 0 || file.array(at).kind != Hdf5Kind::Text || file.array(at).count() != 1) return "";
    return file.read(at).c_str();  // ends with 0
  } catch (const Error&) {
    return "";
  }
}

// Khronos Texture 2.0, 3: pairs of keys and values before the texels.
std::string from_ktx2(const std::filesystem::path& path, const Reading& reading) {
  try {
    const std::string data = read_whole(path, reading);
    const auto word = [&](std::size_t at) {
      std::uint32_t v = 0;
      if (at + 4 <= data.size()) std::memcpy(&v, data.data() + at, sizeof v);
      return std::size_t{v};
    };
    if (data.compare(0, 7, "\xabKTX 20") != 0) return "";
    const std::string key("terrazzo.provenance", 20);  // with the 0 after it
    const std::size_t end = std::min(data.size(), word(56) + word(60));
    for (std::size_t at = word(56), length = 0; at + 4 < end; at += 4 + (length + 3) / 4 * 4) {
      length = std::min(word(at), end - at - 4);
      if (length > key.size() && data.compare(at + 4, key.size(), key) == 0)
        return data.substr(at + 4 + key.size(), length - key.size() - 1);
    }
    return "";
  } catch (const Error&) {
    return "";
  }
}

}  // namespace

std::string read_provenance(const std::filesystem::path& path) {
  const Reading reading;
  const std::string extension = path.extension().string();
  if (extension == ".glb") return from_glb(path, reading);
  if (extension == ".vdb") return from_vdb(path, reading);
  if (extension == ".ktx2") return from_ktx2(path, reading);
  if (extension == ".dream3d") return from_dream3d(path, reading);
  if (extension == ".vti" || extension == ".vtu") return provenance_in_vti(path);
  if (extension == ".usda") return provenance_in_usda(path);
  if (extension == ".xml" || extension == ".pbrt" || extension == ".mtlx") return provenance_in_scene(path);
  if (extension == ".inp") return provenance_in_inp(path);
  if (extension == ".nii" || extension == ".gz") return provenance_in_nifti(path);
  return picture_text(path, "ImageDescription", reading);
}

}  // namespace terrazzo
