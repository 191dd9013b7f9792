#include "nodes/common/io/outlines/outline_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "graph/input_file.h"
#include "nodes/common/io/text_input.h"
#include "runtime/files/json_input.h"

namespace terrazzo {
namespace {

std::string beginning(const std::filesystem::path& path) {
  std::string head = read_beginning(path, 64);
  if (head.starts_with("\xef\xbb\xbf")) head.erase(0, 3);
  head.erase(0, head.find_first_not_of(" \t\r\n"));
  return head;
}

bool is_roi(const std::string& head) { return head.starts_with("Iout"); }
bool is_archive(const std::string& head) { return head.starts_with("PK\3\4") || head.starts_with("PK\5\6"); }

OutlineFile read_json_outlines(const std::filesystem::path& path, const Reading& reading) {
  const std::string text = read_text(path, reading), file = path.string();
  require_memory(3 * memory_to_read_json(text), reading.memory, "the outlines '" + file + "'");
  // COCO's list of annotations is what tells the two apart; a GeoJSON object has a type.
  const auto annotations = text.find("\"annotations\""), type = text.find("\"FeatureCollection\"");
  return annotations != std::string::npos && type == std::string::npos ? read_coco(text, file)
                                                                       : read_geojson(text, file);
}

}  // namespace

bool is_outline_file(const std::filesystem::path& path) {
  const std::string head = beginning(path);
  return is_roi(head) || (is_archive(head) && path.extension() == ".zip") || head.starts_with("{") ||
         head.starts_with("[");
}

OutlineFile read_outline_file(const std::filesystem::path& path, const Reading& reading) {
  const std::string head = beginning(path);
  OutlineFile out;
  if (is_archive(head)) {
    out = read_roi_zip(path, reading);
  } else if (is_roi(head)) {
    out.outlines.push_back(read_roi(read_whole(path, reading), path.string()));
    out.sections = out.outlines[0].section + 1;
  } else {
    out = read_json_outlines(path, reading);
  }
  if (out.outlines.empty())
    throw Error("no-particles", fmt::format("'{}' contains no outlines", path.string()),
                "use a file with polygons or areas")
        .parameter("path");
  require_simple(out, path.string());
  return out;
}

Error bad_outline(const std::string& file, const std::string& what, const std::string& hint) {
  return Error("bad-outline", fmt::format("'{}': {}", file, what), hint).parameter("path");
}

}  // namespace terrazzo
