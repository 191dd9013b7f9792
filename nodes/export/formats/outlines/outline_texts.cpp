// GeoJSON and COCO.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/fill_loops.h"
#include "nodes/export/formats/outlines/outlines.h"
#include "runtime/json_text.h"

namespace terrazzo::exporting {
namespace {
using nlohmann::json;

std::string class_name(int cls) { return fmt::format("class {}", cls); }

// Whole numbers without a decimal point.
json coordinate(double v) {
  if (v == static_cast<double>(static_cast<std::int64_t>(v))) return static_cast<std::int64_t>(v);
  return v;
}

// Outer rings have positive areas, holes negative ones, and the last position is the first.
json ring_of(Loop loop, bool hole) {
  if ((loop_area(loop) < 0) != hole) std::reverse(loop.begin(), loop.end());
  json out = json::array();
  for (const Vec2& p : loop) out.push_back({coordinate(p.x()), coordinate(p.y())});
  out.push_back(out.front());
  return out;
}

json geometry_of(const FileOutline& o, const std::optional<Georeference>& place) {
  json polygons = json::array();
  for (const auto& polygon : polygons_of(o.loops)) {
    json rings = json::array();
    for (Loop loop : polygon) {
      if (place)
        for (Vec2& p : loop) p = place->on_map(p);
      rings.push_back(ring_of(std::move(loop), !rings.empty()));
    }
    polygons.push_back(std::move(rings));
  }
  if (polygons.size() == 1) return {{"type", "Polygon"}, {"coordinates", polygons[0]}};
  return {{"type", "MultiPolygon"}, {"coordinates", std::move(polygons)}};
}

struct Box {
  Vec2 low, high;
};
Box box_of(const std::vector<Loop>& loops) {
  Box b{loops[0][0], loops[0][0]};
  for (const Loop& loop : loops)
    for (const Vec2& p : loop) {
      b.low = b.low.cwiseMin(p);
      b.high = b.high.cwiseMax(p);
    }
  return b;
}

// Alternate lengths of background and object, in columns: the rows of the transposed loops.
json runs_of(const FileOutline& o, int width, int height) {
  std::vector<Loop> transposed = o.loops;
  for (Loop& loop : transposed)
    for (Vec2& p : loop) p = Vec2(p.y(), p.x());
  json counts = json::array();
  std::int64_t at = 0, begun = -1;  // of the run of the object that is not written yet
  const auto end_run = [&] {
    if (begun >= 0) counts.push_back(at - begun);
  };
  std::int64_t written = 0;
  fill_loops(transposed, height, width, [&](int x, int first, int last) {
    const std::int64_t from = static_cast<std::int64_t>(x) * height + first;
    if (begun < 0 || from != at) {
      end_run();
      counts.push_back(from - written);
      begun = from;
    }
    at = static_cast<std::int64_t>(x) * height + last;
    written = at;
  });
  end_run();
  counts.push_back(static_cast<std::int64_t>(width) * height - written);
  return {{"size", {height, width}}, {"counts", std::move(counts)}};
}

json segmentation_of(const FileOutline& o, int width, int height) {
  json out = json::array();
  for (const auto& polygon : polygons_of(o.loops)) {
    if (polygon.size() > 1) return runs_of(o, width, height);
    json numbers = json::array();
    for (const Vec2& p : polygon[0]) {
      numbers.push_back(coordinate(p.x()));
      numbers.push_back(coordinate(p.y()));
    }
    out.push_back(std::move(numbers));
  }
  return out;
}

}  // namespace

std::string geojson_of(const OutlineFile& all) {
  json features = json::array();
  for (const FileOutline& o : all.outlines)
    features.push_back({{"type", "Feature"},
                        {"id", std::stoi(o.name)},
                        {"geometry", geometry_of(o, all.georeference)},
                        {"properties",
                         {{"objectType", "annotation"},
                          {"name", o.name},
                          {"classification", {{"name", class_name(o.cls)}}},
                          {"class", o.cls},
                          {"section", o.section},
                          {"confidence", o.confidence}}}});
  json out = {{"type", "FeatureCollection"},
              {"picture",
               {{"width", all.width},
                {"height", all.height},
                {"sections", all.sections},
                {"pixel_size_mm", all.pixel_size}}},
              {"features", std::move(features)}};
  if (all.georeference) {
    out["picture"]["affine"] = all.georeference->m;
    if (const int epsg = all.georeference->epsg; epsg > 0)
      out["crs"] = {{"type", "name"},
                    {"properties", {{"name", fmt::format("urn:ogc:def:crs:EPSG::{}", epsg)}}}};
  }
  return json_text(out, -1) + "\n";
}

std::string coco_of(const OutlineFile& all) {
  json images = json::array(), categories = json::array(), annotations = json::array();
  int classes = 1;
  for (const FileOutline& o : all.outlines) classes = std::max(classes, o.cls + 1);
  for (int s = 0; s < all.sections; ++s)
    images.push_back({{"id", s + 1},
                      {"width", all.width},
                      {"height", all.height},
                      {"file_name", fmt::format("section_{:03}", s)},
                      {"pixel_size_mm", all.pixel_size}});
  for (int k = 0; k < classes; ++k) categories.push_back({{"id", k + 1}, {"name", class_name(k)}});
  for (const FileOutline& o : all.outlines) {
    double area = 0;
    for (const auto& polygon : polygons_of(o.loops))
      for (std::size_t k = 0; k < polygon.size(); ++k)
        area += (k == 0 ? 1 : -1) * std::abs(loop_area(polygon[k]));
    const Box b = box_of(o.loops);
    annotations.push_back({{"id", annotations.size() + 1},
                           {"image_id", o.section + 1},
                           {"category_id", o.cls + 1},
                           {"segmentation", segmentation_of(o, all.width, all.height)},
                           {"area", area},
                           {"bbox", {b.low.x(), b.low.y(), b.high.x() - b.low.x(), b.high.y() - b.low.y()}},
                           {"iscrowd", 0},
                           {"score", o.confidence}});
  }
  return json_text({{"images", std::move(images)},
                    {"categories", std::move(categories)},
                    {"annotations", std::move(annotations)}},
                   -1) +
         "\n";
}

}  // namespace terrazzo::exporting
