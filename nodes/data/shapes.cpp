#include "nodes/data/shapes.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "nodes/data/class_codec.h"

namespace terrazzo {

double Shape::size() const { return std::sqrt(4 * max_section_area / std::numbers::pi); }

namespace {

// Colors and texture coordinates follow the classes, only if any shape has them, so that values without them
// keep their content hashes.
bool is_painted(const Shapes& v) {
  return std::any_of(v.shapes.begin(), v.shapes.end(),
                     [](const Shape& s) { return !s.color.empty() || !s.uv.empty(); });
}

// What was traced follows colors and coordinates, and trends follow that, again only if there are any.
bool is_traced(const Shapes& v) {
  return std::any_of(v.shapes.begin(), v.shapes.end(), [](const Shape& s) { return s.traced.profile != 0; });
}

void encode(const Shapes& v, Writer& w) {
  w.pod<std::uint64_t>(v.shapes.size());
  for (const auto& s : v.shapes) {
    w.text(s.name);
    w.pod(s.probability), w.pod(s.volume), w.pod(s.surface_area), w.pod(s.mean_caliper),
        w.pod(s.max_section_area);
    w.pod<std::uint8_t>(s.smooth);
    w.raw_array(s.mesh.vertices);
    w.raw_array(s.mesh.triangles);
  }
  const bool trends = have_trend(v.shapes);
  const bool more = is_painted(v) || is_traced(v) || trends;
  encode_classes(v.shapes, w, more);
  if (!more) return;
  for (const Shape& s : v.shapes) {
    w.raw_array(s.color);
    w.raw_array(s.uv);
  }
  if (!is_traced(v) && !trends) return;
  for (const Shape& s : v.shapes) {
    w.pod(s.traced.profile), w.pod(s.traced.turn);
    w.bytes(s.traced.origin.data(), sizeof(double) * 2);
    w.pod(static_cast<std::uint8_t>(s.traced.faceted));
  }
  if (trends) encode_trends(v.shapes, w);
}

Shapes decode_shapes(Reader& r) {
  Shapes v;
  v.shapes.resize(r.count(65));
  for (auto& s : v.shapes) {
    s.name = r.text();
    s.probability = r.pod<double>();
    s.volume = r.pod<double>();
    s.surface_area = r.pod<double>();
    s.mean_caliper = r.pod<double>();
    s.max_section_area = r.pod<double>();
    s.smooth = r.pod<std::uint8_t>() != 0;
    s.mesh.vertices = r.raw_array<Vec3>();
    s.mesh.triangles = r.raw_array<Triangle>();
    for (const auto& t : s.mesh.triangles)
      for (const auto i : t)
        if (i < 0 || static_cast<std::size_t>(i) >= s.mesh.vertices.size())
          throw Error("damaged", "a stored triangle refers to a missing vertex");
  }
  decode_classes(v.shapes, r);
  if (r.left() == 0) return v;
  for (auto& s : v.shapes) {
    s.color = r.raw_array<Vec3f>();
    s.uv = r.raw_array<CornerUv>();
    if (!s.color.empty() && s.color.size() != s.mesh.vertices.size())
      throw Error("damaged", "the stored colors are not one per vertex");
    if (!s.uv.empty() && s.uv.size() != s.mesh.triangles.size())
      throw Error("damaged", "the stored texture coordinates are not three per triangle");
  }
  if (r.left() == 0) return v;
  for (auto& s : v.shapes) {
    s.traced.profile = r.pod<std::int32_t>();
    s.traced.turn = r.pod<double>();
    r.bytes(s.traced.origin.data(), sizeof(double) * 2);
    s.traced.faceted = r.pod<std::uint8_t>() != 0;
  }
  if (r.left() > 0) decode_trends(v.shapes, r);
  return v;
}

nlohmann::json describe(const Shapes& v) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& s : v.shapes)
    list.push_back({{"name", s.name},
                    {"probability", s.probability},
                    {"vertices", s.mesh.vertices.size()},
                    {"triangles", s.mesh.triangles.size()},
                    {"volume", s.volume},
                    {"surface_area", s.surface_area},
                    {"mean_caliper", s.mean_caliper},
                    {"max_section_area", s.max_section_area},
                    {"size", s.size()},
                    {"smooth", s.smooth},
                    {"class", s.cls}});
  for (std::size_t i = 0; i < v.shapes.size(); ++i) {  // as values without colors never had these members
    if (!v.shapes[i].color.empty()) list[i]["colors"] = v.shapes[i].color.size();
    if (!v.shapes[i].uv.empty()) list[i]["uv"] = v.shapes[i].uv.size();
    if (v.shapes[i].traced.profile != 0) list[i]["traced"] = v.shapes[i].traced.profile;
    const SizeTrend& trend = v.shapes[i].trend;
    if (!trend.even()) list[i]["trend"] = {trend.power, trend.size, trend.spread};
  }
  return {{"shapes", std::move(list)}};
}

}  // namespace

template <>
const ValueType& value_type<Shapes>() {
  static const ValueType type = make_value_type<Shapes>(
      "Shapes", "Particle shapes: watertight meshes with probabilities", encode, decode_shapes, describe);
  return type;
}

}  // namespace terrazzo
