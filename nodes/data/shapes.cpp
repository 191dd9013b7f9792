#include "nodes/data/shapes.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "nodes/data/class_codec.h"

namespace terrazzo {

double Shape::size() const { return std::sqrt(4 * max_section_area / std::numbers::pi); }

namespace {

void encode(const Shapes& v, Writer& w) {
  w.pod<std::uint64_t>(v.shapes.size());
  for (const auto& s : v.shapes) {
    w.text(s.name);
    w.pod(s.probability), w.pod(s.volume), w.pod(s.surface_area), w.pod(s.mean_caliper),
        w.pod(s.max_section_area);
    w.pod<std::uint8_t>(s.smooth);
    w.raw_array(s.mesh.vertices), w.raw_array(s.mesh.triangles);
  }
  encode_classes(v.shapes, w);
}

Shapes decode_shapes(Reader& r) {
  Shapes v;
  v.shapes.resize(r.count(65));
  for (auto& s : v.shapes) {
    s.name = r.text();
    s.probability = r.pod<double>(), s.volume = r.pod<double>(), s.surface_area = r.pod<double>();
    s.mean_caliper = r.pod<double>(), s.max_section_area = r.pod<double>();
    s.smooth = r.pod<std::uint8_t>() != 0;
    s.mesh.vertices = r.raw_array<Vec3>(), s.mesh.triangles = r.raw_array<Triangle>();
    for (const auto& t : s.mesh.triangles)
      for (const auto i : t)
        if (i < 0 || static_cast<std::size_t>(i) >= s.mesh.vertices.size())
          throw Error("damaged", "a stored triangle refers to a missing vertex");
  }
  decode_classes(v.shapes, r);
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
