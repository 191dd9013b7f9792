#include "nodes/export/formats/usda_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <set>

#include "graph/text/utf8.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/instances.h"

namespace terrazzo::exporting {
namespace {

// A string literal.
std::string usda_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : escape_controls(text)) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n')
      out += "\\n";
    else
      out += c;
  }
  return out + '"';
}

// A prim's name from any text: letters, digits and underscores, not a digit first, and not used before.
std::string prim_name(const std::string& text, const std::string& otherwise, std::set<std::string>& taken) {
  std::string name;
  for (const char c : text) name += (std::isalnum(static_cast<unsigned char>(c)) && c > 0) ? c : '_';
  if (name.find_first_not_of('_') == std::string::npos) name = otherwise;
  if (std::isdigit(static_cast<unsigned char>(name[0]))) name = "_" + name;
  std::string unique = name;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
  return unique;
}

std::string tuple(const Vec3& v) {
  const Vec3f f = v.cast<float>();
  return fmt::format("({}, {}, {})", f.x(), f.y(), f.z());
}

std::string half(double v) {
  return fmt::format("{:.5g}", static_cast<float>(Eigen::half(static_cast<float>(v))));
}

class UsdaText {
 public:
  UsdaText(std::ostream& out, const Work& work) : out_(out), work_(work) {}
  void line(int depth, const std::string& text) {
    out_ << std::string(4 * static_cast<std::size_t>(depth), ' ') << text << '\n';
  }
  // `declaration` = [item(0), item(1), …], several items per line.
  template <class Item>
  void array(int depth, const std::string& declaration, std::size_t count, Item&& item,
             const char* end = "") {
    const std::string indent(4 * static_cast<std::size_t>(depth), ' ');
    out_ << indent << declaration << " = [";
    for (std::size_t i = 0; i < count; ++i) {
      if (i % 65536 == 0) work_.check();
      out_ << (i == 0 ? "" : i % 8 ? ", " : ",\n    " + indent) << item(i);
    }
    out_ << "]" << end << '\n';
  }

 private:
  std::ostream& out_;
  const Work& work_;
};

constexpr const char* kPerInstance = " (interpolation = \"vertex\")";

Eigen::AlignedBox3d box_of(const std::vector<Vec3>& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

// Triangles as the shape has them, so that faceted shapes stay welded; normals only for smooth ones.
Eigen::AlignedBox3d add_mesh(UsdaText& text, int depth, const Shape& shape, const std::string& name) {
  const RenderMesh render = render_mesh(shape);  // checks the mesh, too
  const Mesh& mesh = shape.mesh;
  const auto box = box_of(mesh.vertices);
  text.line(depth, fmt::format("def Mesh \"{}\" (", name));
  text.line(depth + 1, "prepend apiSchemas = [\"MaterialBindingAPI\"]");
  text.line(depth + 1, fmt::format("customData = {{ string name = {} }}", usda_text(shape.name)));
  text.line(depth, ")");
  text.line(depth, "{");
  text.line(depth + 1, fmt::format("float3[] extent = [{}, {}]", tuple(box.min()), tuple(box.max())));
  text.array(depth + 1, "int[] faceVertexCounts", mesh.triangles.size(), [](std::size_t) { return "3"; });
  text.array(depth + 1, "int[] faceVertexIndices", 3 * mesh.triangles.size(),
             [&](std::size_t i) { return mesh.triangles[i / 3][i % 3]; });
  text.array(depth + 1, "point3f[] points", mesh.vertices.size(),
             [&](std::size_t i) { return tuple(mesh.vertices[i]); });
  if (shape.smooth)
    text.array(
        depth + 1, "normal3f[] normals", render.normals.size(),
        [&](std::size_t i) { return tuple(render.normals[i]); }, kPerInstance);
  if (!shape.color.empty())
    text.array(
        depth + 1, "color3f[] primvars:displayColor", shape.color.size(),
        [&](std::size_t i) { return tuple(shape.color[i].cast<double>()); }, kPerInstance);
  text.line(depth + 1, "uniform token subdivisionScheme = \"none\"");
  text.line(depth + 1, "rel material:binding = </Aggregate/Looks/Particle>");
  text.line(depth, "}");
  return box;
}

void add_header(UsdaText& text, const std::string& data, const std::string& provenance) {
  text.line(0, "#usda 1.0");
  text.line(0, "(");
  text.line(1, "customLayerData = {");
  text.line(2, "string creator = \"Terrazzo\"");
  if (!data.empty()) text.line(2, data);
  if (!provenance.empty()) text.line(2, "string provenance = " + usda_text(provenance));
  text.line(1, "}");
  text.line(1, "defaultPrim = \"Aggregate\"");
  text.line(1, "metersPerUnit = 0.001");
  text.line(1, "upAxis = \"Z\"");
  text.line(0, ")");
  text.line(0, "");
  text.line(0, "def Xform \"Aggregate\" (");
  text.line(1, "kind = \"component\"");
  text.line(0, ")");
  text.line(0, "{");
}

void add_material(UsdaText& text) {
  for (const char* line :
       {"    def Scope \"Looks\"",
        "    {",
        "        def Material \"Particle\"",
        "        {",
        "            token outputs:surface.connect = </Aggregate/Looks/Particle/Surface.outputs:surface>",
        "",
        "            def Shader \"Surface\"",
        "            {",
        "                uniform token info:id = \"UsdPreviewSurface\"",
        "                color3f inputs:diffuseColor.connect = "
        "</Aggregate/Looks/Particle/Color.outputs:result>",
        "                float inputs:roughness = 0.6",
        "                float inputs:metallic = 0",
        "                token outputs:surface",
        "            }",
        "",
        "            def Shader \"Color\"",
        "            {",
        "                uniform token info:id = \"UsdPrimvarReader_float3\"",
        "                string inputs:varname = \"displayColor\"",
        "                float3 inputs:fallback = (0.5, 0.5, 0.5)",
        "                float3 outputs:result",
        "            }",
        "        }",
        "    }"})
    text.line(0, line);
}

void add_volume(UsdaText& text, const UsdaVolume& volume) {
  std::set<std::string> taken;
  std::map<std::string, std::string> names;  // prim of each grid
  for (const std::string& grid : grid_names(*volume.volume)) names[grid] = prim_name(grid, "grid", taken);
  text.line(1, "def Volume \"Volume\"");
  text.line(1, "{");
  text.line(2, "token visibility = \"invisible\"");
  for (const auto& [grid, prim] : names)
    text.line(2, fmt::format("rel field:{} = </Aggregate/Volume/{}>", prim, prim));
  for (const auto& [grid, prim] : names) {
    text.line(0, "");
    text.line(2, fmt::format("def OpenVDBAsset \"{}\"", prim));
    text.line(2, "{");
    text.line(3, fmt::format("asset filePath = @./{}@", volume.file));
    text.line(3, fmt::format("token fieldName = {}", usda_text(grid)));
    text.line(2, "}");
  }
  text.line(1, "}");
}

void add_end(UsdaText& text, const UsdaVolume& volume) {
  add_material(text);
  if (volume.volume) {
    text.line(0, "");
    add_volume(text, volume);
  }
  text.line(0, "}");
}

// As OpenUSD computes it: the transformed boxes of the prototypes.
Eigen::AlignedBox3d extent_of(const Particles& particles, const Shapes& shapes,
                              const std::vector<std::size_t>& solid) {
  Eigen::AlignedBox3d extent;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Shape& s : shapes.shapes) boxes.push_back(box_of(s.mesh.vertices));
  for (const std::size_t i : solid)
    for (int c = 0; c < 8; ++c) {
      const Vec3 corner = boxes[particles.shape[i]].corner(static_cast<Eigen::AlignedBox3d::CornerType>(c));
      extent.extend(particles.position[i] +
                    particles.orientation[i].normalized() * (particles.scale[i] * corner));
    }
  return extent;
}

// `solid`: the particles that are written. `prototype`: the number of each shape's prototype.
void add_instances(UsdaText& text, const Particles& particles, const std::vector<std::size_t>& solid,
                   const std::vector<int>& prototype, const std::vector<std::int32_t>& index) {
  const std::size_t n = solid.size();
  text.array(2, "int[] protoIndices", n, [&](std::size_t i) { return prototype[particles.shape[solid[i]]]; });
  text.array(2, "int64[] ids", n, [&](std::size_t i) { return solid[i]; });
  text.array(2, "point3f[] positions", n, [&](std::size_t i) { return tuple(particles.position[solid[i]]); });
  text.array(2, "quath[] orientations", n, [&](std::size_t i) {
    const Quat q = particles.orientation[solid[i]].normalized();
    return fmt::format("({}, {}, {}, {})", half(q.w()), half(q.x()), half(q.y()), half(q.z()));
  });
  text.array(2, "float3[] scales", n,
             [&](std::size_t i) { return tuple(Vec3::Constant(particles.scale[solid[i]])); });
  text.array(
      2, "color3f[] primvars:displayColor", n,
      [&](std::size_t i) { return tuple(particles.color[solid[i]].cast<double>()); }, kPerInstance);
  text.array(
      2, "int[] primvars:class", n, [&](std::size_t i) { return particles.cls[solid[i]]; }, kPerInstance);
  text.array(
      2, "float[] primvars:size", n,
      [&](std::size_t i) { return fmt::format("{}", static_cast<float>(particles.size[solid[i]])); },
      kPerInstance);
  if (!index.empty())
    text.array(
        2, "int[] primvars:particle", n, [&](std::size_t i) { return index[solid[i]]; }, kPerInstance);
}

}  // namespace

void write_usda(const std::filesystem::path& path, const Particles& particles, const Shapes& shapes,
                const UsdaVolume& volume, const std::string& provenance, const Work& work,
                const std::vector<std::int32_t>& index) {
  const auto members = instances_of(particles, shapes);
  std::vector<std::size_t> solid;  // particles that are written
  std::vector<int> prototype(members.size(), -1);
  std::vector<std::string> names;  // of prototypes
  std::set<std::string> taken;
  for (std::size_t s = 0; s < members.size(); ++s) {
    if (members[s].empty()) continue;
    prototype[s] = names.size();
    names.push_back(prim_name(shapes.shapes[s].name, "shape", taken));
    render_mesh(shapes.shapes[s]);  // throws before anything is written
  }
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) solid.push_back(i);

  const Eigen::AlignedBox3d extent = extent_of(particles, shapes, solid);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    UsdaText text(out, work);
    add_header(
        text,
        fmt::format("double3 box_mm = ({}, {}, {})", particles.box.x(), particles.box.y(), particles.box.z()),
        provenance);
    text.line(1, "def PointInstancer \"Particles\"");
    text.line(1, "{");
    text.line(2, fmt::format("float3[] extent = [{}, {}]", tuple(extent.min()), tuple(extent.max())));
    text.array(2, "rel prototypes", names.size(),
               [&](std::size_t i) { return fmt::format("</Aggregate/Particles/Prototypes/{}>", names[i]); });
    add_instances(text, particles, solid, prototype, index);
    text.line(0, "");
    text.line(2, "def Scope \"Prototypes\"");
    text.line(2, "{");
    for (std::size_t s = 0; s < members.size(); ++s) {
      work.check();
      work.progress(double(s) / double(members.size()));
      if (prototype[s] >= 0) add_mesh(text, 3, shapes.shapes[s], names[prototype[s]]);
    }
    text.line(2, "}");
    text.line(1, "}");
    text.line(0, "");
    add_end(text, volume);
  });
}

void write_usda(const std::filesystem::path& path, const Shapes& shapes, const UsdaVolume& volume,
                const std::string& provenance, const Work& work) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to write");
  for (const Shape& s : shapes.shapes) render_mesh(s);  // throws before anything is written
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    UsdaText text(out, work);
    add_header(text, "", provenance);
    std::set<std::string> taken = {"Looks", "Volume"};
    for (const Shape& s : shapes.shapes) {
      work.check();
      add_mesh(text, 1, s, prim_name(s.name, "shape", taken));
      text.line(0, "");
    }
    add_end(text, volume);
  });
}

}  // namespace terrazzo::exporting
