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

OutlineFile json_outlines(const std::string& text, const std::string& file, const Reading& reading,
                          const Work& work) {
  require_memory(3 * memory_to_read_json(text), reading.memory, "the outlines '" + file + "'");
  // COCO's list of annotations is what tells the two apart; a GeoJSON object has a type.
  const auto annotations = text.find("\"annotations\""), type = text.find("\"FeatureCollection\"");
  return annotations != std::string::npos && type == std::string::npos ? read_coco(text, file, reading, work)
                                                                       : read_geojson(text, file);
}

}  // namespace

void to_pixels(OutlineFile& outlines, const Georeference& place) {
  for (FileOutline& o : outlines.outlines)
    for (Loop& loop : o.loops)
      for (Vec2& p : loop) p = place.in_picture(p);
}

namespace {

// From coordinates on the map of the picture.
void take_to_pixels(OutlineFile& all, const Georeference& place, const std::string& file) {
  if (all.epsg > 0 && place.epsg > 0 && all.epsg != place.epsg)
    throw Error(
        "bad-georeference",
        fmt::format("the outlines of '{}' have the coordinate system EPSG:{}, but the connected picture "
                    "has EPSG:{}",
                    file, all.epsg, place.epsg),
        "reproject the outlines")
        .parameter("path");
  to_pixels(all, place);
  all.on_map = false;
}

OutlineFile checked_outlines(OutlineFile all, const std::string& file, const Work& work,
                             const MapPlace& place) {
  if (all.outlines.empty())
    throw Error("no-particles", fmt::format("'{}' contains no outlines", file),
                "use a file with polygons or areas")
        .parameter("path");
  if (all.on_map && place) take_to_pixels(all, *place, file);
  require_simple(all, file, work);
  return all;
}

}  // namespace

bool is_outline_file(const std::filesystem::path& path) {
  const std::string head = beginning(path);
  return is_region_file(path) || head.starts_with("{") || head.starts_with("[");
}

bool is_region_file(const std::filesystem::path& path) {
  const std::string head = beginning(path);
  return is_roi(head) || (is_archive(head) && path.extension() == ".zip");
}

OutlineFile read_outline_text(const std::string& text, const std::string& file, const Reading& reading,
                              const Work& work, const MapPlace& place) {
  return checked_outlines(json_outlines(text, file, reading, work), file, work, place);
}

OutlineFile read_outline_file(const std::filesystem::path& path, const Reading& reading, const Work& work,
                              const MapPlace& place) {
  const std::string head = beginning(path);
  OutlineFile out;
  if (is_archive(head)) {
    out = read_roi_zip(path, reading);
  } else if (is_roi(head)) {
    out.outlines.push_back(read_roi(read_whole(path, reading), path.string()));
    out.sections = out.outlines[0].section + 1;
  } else {
    return read_outline_text(read_text(path, reading), path.string(), reading, work, place);
  }
  return checked_outlines(std::move(out), path.string(), work, place);
}

void take_picture(OutlineFile& outlines, const Image& picture, bool all_sections, const std::string& file) {
  if ((outlines.width > 0 && (outlines.width != picture.width || outlines.height != picture.height)) ||
      (all_sections && outlines.sections > picture.sections))
    throw Error(
        "size-mismatch",
        fmt::format(
            "the outlines of '{}' are of {} sections{}, but the connected picture has {} of "
            "{} × {} pixels",
            file, outlines.sections,
            outlines.width > 0 ? fmt::format(" of {} × {} pixels", outlines.width, outlines.height) : "",
            picture.sections, picture.width, picture.height),
        "use the outlines of this picture")
        .parameter("path");
  outlines.width = picture.width;
  outlines.height = picture.height;
  if (all_sections) outlines.sections = picture.sections;
  require_inside(outlines, file);
}

Error bad_outline(const std::string& file, const std::string& what, const std::string& hint) {
  return Error("bad-outline", fmt::format("'{}': {}", file, what), hint).parameter("path");
}

}  // namespace terrazzo
