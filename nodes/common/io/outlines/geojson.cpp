#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/text/read_number.h"
#include "nodes/common/io/json_input.h"
#include "nodes/common/io/outlines/outline_file.h"

namespace terrazzo {
namespace {
using nlohmann::json;

constexpr int kMostSections = 1'000'000;

// A list of positions; the last one repeats the first.
Loop ring_of(const json& ring, const std::string& name, const std::string& file) {
  const auto wrong = [&] {
    return bad_outline(file, name + " has a ring that is not a list of at least four positions [x, y]",
                       "write polygons as RFC 7946 says");
  };
  if (!ring.is_array() || ring.size() < 4) throw wrong();
  Loop out;
  for (const json& p : ring) {
    if (!p.is_array() || p.size() < 2 || !p[0].is_number() || !p[1].is_number()) throw wrong();
    out.emplace_back(p[0].get<double>(), p[1].get<double>());
    if (!out.back().allFinite()) throw wrong();
  }
  if (out.back() == out.front()) out.pop_back();
  return out;
}

// A property, if it is a number; other programs may use its name for something else.
std::optional<double> number_of(const json& properties, const char* property, double most, bool whole,
                                const std::string& name, const std::string& file) {
  const auto it = properties.find(property);
  if (it == properties.end() || !it->is_number()) return {};
  const auto v = it->get<double>();
  if (v >= 0 && v <= most && (!whole || v == std::floor(v))) return v;
  throw bad_outline(file,
                    fmt::format("{} has the {} {:.6g}, which is no {} from 0 to {:.7g}", name, property, v,
                                whole ? "whole number" : "number", most),
                    "correct the property");
}

// The class of a feature: a number of ours, or the name of a class of QuPath, which `names` collects.
struct GeoClass {
  int number = 0;
  std::string name;
};
GeoClass class_of(const json& properties, const std::string& name, const std::string& file) {
  GeoClass out;
  if (const auto own = number_of(properties, "class", 1e6, true, name, file))
    out.number = static_cast<int>(*own);
  else if (const auto it = properties.find("classification"); it != properties.end() && it->is_object())
    out.name = it->value("name", json()).is_string() ? it->at("name").get<std::string>() : "";
  return out;
}

void add_polygon(const json& coordinates, FileOutline& out, const std::string& file) {
  if (!coordinates.is_array() || coordinates.empty())
    throw bad_outline(file, out.name + " has no coordinates", "write polygons as RFC 7946 says");
  for (const json& ring : coordinates) out.loops.push_back(ring_of(ring, out.name, file));
}

// False for points and lines, which are no particles.
bool add_geometry(const json& geometry, FileOutline& out, const std::string& file) {
  if (!geometry.is_object()) return false;
  const auto type = geometry.find("type"), coordinates = geometry.find("coordinates");
  if (type == geometry.end() || coordinates == geometry.end()) return false;
  if (*type == "Polygon") {
    add_polygon(*coordinates, out, file);
  } else if (*type == "MultiPolygon" && coordinates->is_array()) {
    for (const json& polygon : *coordinates) add_polygon(polygon, out, file);
  }
  return !out.loops.empty();
}

// What Export writes beside the features.
void read_picture(const json& all, OutlineFile& out) {
  const auto it = all.find("picture");
  if (it == all.end() || !it->is_object()) return;
  const auto number = [&](const char* name, double most) {
    const auto v = it->find(name);
    return v != it->end() && v->is_number() && v->get<double>() > 0 && v->get<double>() <= most
               ? v->get<double>()
               : 0.0;
  };
  out.width = static_cast<int>(number("width", 1e6));
  out.height = static_cast<int>(number("height", 1e6));
  if (out.width == 0 || out.height == 0) out.width = out.height = 0;
  out.sections = std::max(1, static_cast<int>(number("sections", kMostSections)));
  out.pixel_size = number("pixel_size_mm", 1e9);
  const auto affine = it->find("affine");
  if (affine == it->end() || !affine->is_array() || affine->size() != 6) return;
  Georeference g;
  for (std::size_t k = 0; k < 6; ++k) {
    if (!(*affine)[k].is_number()) return;
    g.m[k] = (*affine)[k].get<double>();
  }
  if (const double area = g.m[0] * g.m[4] - g.m[1] * g.m[3]; std::isfinite(area) && area != 0)
    out.georeference = g;
}

// The coordinate system, as QGIS and GDAL write it.
void read_system(const json& all, OutlineFile& out) {
  const auto it = all.find("crs");
  if (it == all.end() || !it->is_object()) return;
  out.on_map = true;
  const auto properties = it->find("properties");
  if (properties == it->end() || !properties->is_object()) return;
  const auto name = properties->find("name");
  if (name == properties->end() || !name->is_string()) return;
  const std::string text = name->get<std::string>();
  const auto at = text.rfind(':');
  if (text.find("EPSG") == text.npos || at == text.npos) return;
  const auto number = read_number(std::string_view(text).substr(at + 1));
  if (number && *number > 0 && *number < 1e6) out.epsg = static_cast<int>(*number);
}

}  // namespace

OutlineFile read_geojson(const std::string& text, const std::string& file) {
  const json all = parse_json(text, "", {file, "use GeoJSON with polygons, or COCO"});
  const json* features = &all;
  if (all.is_object()) {
    const auto it = all.find("features");
    if (it != all.end()) features = &*it;
  }
  const json alone = json::array({all});
  if (features == &all && all.is_object()) features = &alone;
  OutlineFile out;
  if (all.is_object()) read_picture(all, out);
  if (all.is_object()) read_system(all, out);
  if (!features->is_array())
    throw Error("unreadable-outlines", fmt::format("'{}' is neither GeoJSON nor COCO", file),
                "use GeoJSON with polygons, or COCO")
        .parameter("path");
  std::map<std::string, int> names;
  std::vector<std::string> named;
  std::size_t number = 0, others = 0;
  for (const json& feature : *features) {
    ++number;
    FileOutline one;
    one.name = fmt::format("feature {}", number);
    const json* geometry = &feature;
    const json none = json::object();
    const json* properties = &none;
    if (feature.is_object() && feature.contains("geometry")) {
      geometry = &feature.at("geometry");
      if (feature.contains("properties") && feature.at("properties").is_object())
        properties = &feature.at("properties");
    }
    if (!add_geometry(*geometry, one, file)) {
      ++others;
      continue;
    }
    const GeoClass cls = class_of(*properties, one.name, file);
    one.cls = cls.number;
    names.emplace(cls.name, 0);
    named.push_back(cls.name);
    if (const auto v = number_of(*properties, "section", kMostSections - 1, true, one.name, file))
      one.section = static_cast<int>(*v);
    if (const auto v = number_of(*properties, "confidence", 1, false, one.name, file)) one.confidence = *v;
    out.sections = std::max(out.sections, one.section + 1);
    out.outlines.push_back(std::move(one));
  }
  if (out.outlines.empty() && others > 0)
    throw Error("unreadable-outlines",
                fmt::format("'{}' is neither COCO nor GeoJSON with polygons: none of its {} features is one",
                            file, others),
                "use polygons, not points or lines")
        .parameter("path");
  if (names.size() > 1) {
    int next = 0;
    for (auto& [name, value] : names) value = next++;
    for (std::size_t i = 0; i < named.size(); ++i)
      if (out.outlines[i].cls == 0) out.outlines[i].cls = names.at(named[i]);
  }
  if (out.georeference) {
    to_pixels(out, *out.georeference);
    out.on_map = false;
  }
  return out;
}

}  // namespace terrazzo
