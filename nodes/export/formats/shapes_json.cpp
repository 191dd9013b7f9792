#include "nodes/export/formats/shapes_json.h"

#include "nodes/data/json.h"

namespace terrazzo::exporting {

nlohmann::json json_with_meshes(const Shapes& shapes) {
  using Json = nlohmann::json;
  Json out = value_type<Shapes>().describe(&shapes);
  for (std::size_t i = 0; i < shapes.shapes.size(); ++i) {
    const Shape& s = shapes.shapes[i];
    Json& mesh = out["shapes"][i]["mesh"];
    mesh = {{"vertices", Json::array()}, {"triangles", s.mesh.triangles}};
    for (const Vec3& v : s.mesh.vertices) mesh["vertices"].push_back(json_of(v));
    for (const Vec3f& c : s.color) mesh["color"].push_back(json_of(c));
    for (const CornerUv& t : s.uv)
      mesh["uv"].push_back({t[0].x(), t[0].y(), t[1].x(), t[1].y(), t[2].x(), t[2].y()});
  }
  return out;
}

}  // namespace terrazzo::exporting
