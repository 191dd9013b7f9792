#include "nodes/shapes/load_shapes/read_shapes.h"

#include <fmt/format.h>

#include <limits>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/io/json_input.h"

namespace terrazzo::load_shapes {
namespace {
using Json = nlohmann::json;

constexpr double kSumTolerance = 1e-6;  // of the probabilities
constexpr int kMostInt = std::numeric_limits<int>::max();

Triangle triangle_of(const JsonObject& o, const Json& list, std::size_t vertices) {
  o.require_size("triangles", list, 3);
  Triangle out;
  for (std::size_t k = 0; k < 3; ++k) {
    const double i = o.number_in("triangles", list[k], 0, static_cast<double>(vertices) - 1);
    if (i != std::floor(i))
      o.fail(fmt::format("a triangle has the vertex {}, which is not a whole number", i));
    out[k] = static_cast<std::int32_t>(i);
  }
  return out;
}

void read_mesh(const JsonObject& o, Shape& s) {
  for (const Json& v : o.list("vertices")) s.mesh.vertices.push_back(o.vector<Vec3>("vertices", v));
  for (const Json& t : o.list("triangles"))
    s.mesh.triangles.push_back(triangle_of(o, t, s.mesh.vertices.size()));
  if (o.has("color"))
    for (const Json& c : o.list("color")) s.color.push_back(o.vector<Vec3f>("color", c));
  if (o.has("uv"))
    for (const Json& t : o.list("uv")) {
      const auto corners = o.vector<Eigen::Matrix<float, 6, 1>>("uv", t);
      s.uv.push_back({corners.segment<2>(0), corners.segment<2>(2), corners.segment<2>(4)});
    }
  if (!s.color.empty() && s.color.size() != s.mesh.vertices.size())
    o.fail(fmt::format("has {} vertices, but {} colors", s.mesh.vertices.size(), s.color.size()));
  if (!s.uv.empty() && s.uv.size() != s.mesh.triangles.size())
    o.fail(fmt::format("has {} triangles, but {} rows of uv", s.mesh.triangles.size(), s.uv.size()));
}

Shape shape_of(const JsonObject& o) {
  Shape s;
  s.name = o.text("name");
  s.probability = o.number("probability", 0, 1 + kSumTolerance);
  s.cls = o.whole("class", -1, kMostInt);
  s.volume = o.number("volume", JsonObject::kSmallest);
  s.surface_area = o.number("surface_area", JsonObject::kSmallest);
  s.mean_caliper = o.number("mean_caliper", JsonObject::kSmallest);
  s.max_section_area = o.number("max_section_area", JsonObject::kSmallest);
  s.smooth = o.boolean("smooth");
  if (o.has("trend")) {
    const auto trend = o.vector<Vec3>("trend");
    if (!(trend.y() > 0 && trend.z() >= 0))
      o.fail("the size in the field trend must be above 0, the spread 0 or more");
    s.trend = {trend.x(), trend.y(), trend.z()};
  }
  return s;
}

void check_solid(const Mesh& mesh, const JsonSource& source, const std::string& what) {
  if (const auto faults = mesh_faults(mesh); !faults.empty())
    throw Error("open-mesh", fmt::format("'{}': {}is not watertight: {}", source.file, what, faults[0]),
                "close the mesh in a mesh editor, and load it with LoadMesh")
        .parameter("path");
  if (!(mesh_volume(mesh) > 0))
    throw Error("inside-out", fmt::format("'{}': {}is inside out or encloses no volume", source.file, what),
                "load the mesh with LoadMesh and repair: true")
        .parameter("path");
}

}  // namespace

Shapes read_shapes(const std::string& text, const std::string& file, const Work& work) {
  const JsonSource source{file, "use a .json file that Export wrote from shapes"};
  const Json json = parse_json(text, "shapes", source);
  const JsonObject all(json, source);
  Shapes out;
  double sum = 0;
  for (const Json& j : all.list("shapes")) {
    work.check();
    const std::string what = fmt::format("shape {}: ", out.shapes.size());
    const JsonObject one(j, source, what, "bad-shape");
    Shape s = shape_of(one);
    read_mesh(JsonObject(one.field("mesh"), source, what + "the mesh ", "bad-shape"), s);
    check_solid(s.mesh, source, what);
    sum += s.probability;
    out.shapes.push_back(std::move(s));
  }
  if (!out.shapes.empty() && !(std::abs(sum - 1) <= kSumTolerance))
    throw Error("bad-probabilities",
                fmt::format("'{}': the probabilities of the shapes sum to {:g} instead of 1", file, sum),
                "divide them by their sum")
        .parameter("path");
  return out;
}

}  // namespace terrazzo::load_shapes
