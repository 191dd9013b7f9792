#include "nodes/common/provenance.h"

#include <OpenImageIO/imageio.h>
#include <openvdb/io/File.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "nodes/data/volume.h"
#include "runtime/files.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace {

// glTF 2.0, 4.4: a header of 12 bytes, then the JSON chunk's length and type.
std::string from_glb(const std::filesystem::path& path) {
  const auto data = read_file(path);
  std::uint32_t length = 0;
  if (!data || data->size() < 20 || data->compare(0, 4, "glTF") != 0) return "";
  std::memcpy(&length, data->data() + 12, sizeof length);
  if (length > data->size() - 20) return "";
  const auto json = nlohmann::json::parse(data->data() + 20, data->data() + 20 + length, nullptr, false);
  const auto extras = nlohmann::json::json_pointer("/asset/extras");
  return json.is_object() && json.contains(extras) ? json_text(json.at(extras)) : "";
}

std::string from_vdb(const std::filesystem::path& path) {
  initialize_openvdb();
  try {
    openvdb::io::File file(path.string());
    file.open(/*delayLoad=*/true);
    const auto meta = file.getMetadata()->getMetadata<openvdb::StringMetadata>("provenance");
    return meta ? meta->value() : "";
  } catch (const openvdb::Exception&) {
    return "";
  }
}

std::string from_picture(const std::filesystem::path& path) {
  const auto in = OIIO::ImageInput::open(path.string());
  if (!in) {
    OIIO::geterror();  // none of its formats: its message is read so that it does not linger
    return "";
  }
  return in->spec().get_string_attribute("ImageDescription");
}

}  // namespace

std::string read_provenance(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".glb") return from_glb(path);
  if (extension == ".vdb") return from_vdb(path);
  return from_picture(path);
}

}  // namespace terrazzo
