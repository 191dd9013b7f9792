#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "graph/text/utf8.h"
#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/reduce.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/bodies.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "nodes/shapes/load_mesh/repair.h"
#include "nodes/shapes/load_mesh/surface.h"
#include "runtime/context.h"

namespace terrazzo::load_mesh {
namespace {

// Each body is measured, which takes milliseconds. More are debris of a scan.
constexpr std::size_t kMostBodies = 100000;

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const auto& p : parts) text += (text.empty() ? "" : "; ") + p;
  return text;
}

std::vector<std::string> faults_of(const std::vector<Mesh>& surfaces) {
  for (const Mesh& surface : surfaces)
    if (auto faults = mesh_faults(surface); !faults.empty()) return faults;
  return {};
}

// The surfaces of a mesh as it is stored if they are closed. Otherwise those with equal positions joined,
// since many files repeat the vertices for each face (texture seams, STL), and then those with positions
// joined that differ by the rounding of single precision. `faults`: what keeps them from being closed.
std::vector<Mesh> closed_surfaces(const Mesh& stored, std::vector<std::string>& faults) {
  Aabb box;
  for (const Vec3& v : stored.vertices) box.add(v);
  const double rounding = 0x1p-23 * (box.high - box.low).norm();
  auto surfaces = connected_surfaces(stored);
  faults = faults_of(surfaces);
  for (const double distance : {0.0, rounding}) {
    if (faults.empty()) return surfaces;
    Mesh welded = stored;
    weld(welded, distance);
    surfaces = connected_surfaces(welded);
    if (faults_of(surfaces).empty()) return faults.clear(), surfaces;
    if (distance == 0) faults = mesh_faults(welded);
  }
  return {};
}

// With repair, what is left to do once the surfaces are closed: flat ones are dropped, and those that face
// inward are turned, all of them if the file as a whole is inside out.
void repair_surfaces(std::vector<Mesh>& surfaces, std::vector<std::string>& done, const Work& work) {
  const auto turn = [](Mesh& mesh) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh.triangles.size();
  };
  double volume = 0;
  for (const Mesh& s : surfaces) volume += mesh_volume(s);
  std::size_t turned = 0;
  if (volume < 0)
    for (Mesh& s : surfaces) turned += turn(s);
  const Bodies sorted = bodies_of(surfaces, work);
  for (const std::size_t i : sorted.inverted) turned += turn(surfaces[i]);
  if (turned > 0) done.push_back(fmt::format("flipped {} triangles", turned));
  if (sorted.flat.empty() || sorted.flat.size() == surfaces.size()) return;
  done.push_back(fmt::format("dropped {} surface{} without volume", sorted.flat.size(),
                             sorted.flat.size() == 1 ? "" : "s"));
  for (std::size_t k = sorted.flat.size(); k-- > 0;) surfaces.erase(surfaces.begin() + sorted.flat[k]);
}

std::string near(const Mesh& surface) {
  const Vec3& v = surface.vertices.at(0);
  return fmt::format("at ({:.9g}, {:.9g}, {:.9g})", v.x(), v.y(), v.z());
}

// The bodies in a file, in the order in which it lists their surfaces.
std::vector<Mesh> bodies_from(Context& c, const std::filesystem::path& path, const Work& work) {
  const std::string name = path.filename().string();
  const bool may_repair = c.boolean("repair");
  Mesh stored = triangles_of(read_mesh(path, reading_of(c)), work);
  std::vector<std::string> faults, done;
  std::vector<Mesh> surfaces = closed_surfaces(stored, faults);
  if (!faults.empty() && may_repair) {
    weld(stored, 0);
    done = repair(stored, work);
    surfaces = connected_surfaces(stored);
    faults = faults_of(surfaces);
  }
  if (!faults.empty())
    throw Error("open-mesh", fmt::format("{} is not watertight: {}", name, joined(faults)),
                may_repair ? "repair could not close it: close it in a mesh editor"
                           : "set repair: true, or close it in a mesh editor");
  if (may_repair) repair_surfaces(surfaces, done, work);
  if (!done.empty()) c.warn(name + ": " + joined(done));
  Bodies sorted = bodies_of(surfaces, work);
  const auto refuse = [&](const std::vector<std::size_t>& which, const char* what, const char* hint) {
    if (!which.empty())
      throw Error("inside-out",
                  fmt::format("{}: {} of {} surfaces {}, the first {}", name, which.size(), surfaces.size(),
                              what, near(surfaces[which[0]])),
                  may_repair ? "use a mesh with a volume" : hint);
  };
  refuse(sorted.inverted, "face inward and lie in no body", "set repair: true to flip them");
  refuse(sorted.flat, "enclose no volume", "set repair: true to drop them");
  if (sorted.bodies.size() > kMostBodies)
    throw Error("too-many-bodies",
                fmt::format("{} contains {} bodies, more than {}", name, sorted.bodies.size(), kMostBodies),
                "divide the file");
  return std::move(sorted.bodies);
}

void warn_of_bodies(Context& c, const std::string& file, const std::vector<Mesh>& bodies, double scale) {
  if (bodies.size() < 2) return;
  double least = 1e300, most = 0;
  for (const Mesh& b : bodies) {
    const double volume = mesh_volume(b) * scale * scale * scale;
    least = std::min(least, volume);
    most = std::max(most, volume);
  }
  c.warn(fmt::format("{} contains {} bodies of {:.4g} to {:.4g} mm³; each becomes a shape", file,
                     bodies.size(), least, most));
}

Shape surface_from(Context& c, const std::filesystem::path& path) {
  const PolygonSoup soup = read_mesh(path, reading_of(c), TextureCoordinates::Read);
  if (soup.without_uv > 0 && soup.without_uv < soup.polygons.size())
    c.warn(fmt::format(
        "{}: {} of {} faces have no UV coordinates, so those of the others are left out; unwrap all "
        "faces in a mesh editor",
        path.filename().string(), soup.without_uv, soup.polygons.size()));
  return surface_of(soup, c.memory(), c.work());
}

// For `surface`: each file is one shape.
Shapes surfaces_from(Context& c) {
  const auto& files = c.files("path");
  Shapes shapes;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string stem = files[i].stem().string();
    try {
      Shape shape = surface_from(c, files[i]);
      for (Vec3& v : shape.mesh.vertices) v *= c.number("scale");
      shape.surface_area *= c.number("scale") * c.number("scale");
      shape.name = valid_utf8(stem);
      shape.probability = 1.0 / count_of(files);
      shape.smooth = c.boolean("smooth");
      shapes.shapes.push_back(std::move(shape));
    } catch (Error& e) {
      throw e.parameter("path");
    }
  }
  return shapes;
}

void compute_surfaces(Context& c) {
  if (c.boolean("repair") || c.keyword("max_triangles").empty())
    throw Error("bad-value", "a surface is not repaired or simplified",
                "leave repair and max_triangles out, or set surface: false")
        .parameter("surface");
  Shapes shapes = surfaces_from(c);
  double triangles = 0;
  for (const Shape& s : shapes.shapes) triangles += count_of(s.mesh.triangles);
  c.metric("shapes", count_of(shapes.shapes));
  c.metric("triangles", triangles);
  c.metric("volume", 0);
  c.output("shapes", std::move(shapes));
}

void compute(Context& c) {
  if (c.boolean("surface")) return compute_surfaces(c);
  const auto& files = c.files("path");
  const double scale = c.number("scale");
  struct Body {
    std::string name;
    Mesh mesh;
  };
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Work work = c.work().part(0.5 * i / files.size(), 0.5 * (i + 1) / files.size());
    std::vector<Mesh> found;
    try {
      found = bodies_from(c, files[i], work);
      if (c.keyword("max_triangles").empty())
        for (Mesh& m : found) reduce_triangles(m, c.integer("max_triangles"), work);
    } catch (Error& e) {
      throw e.parameter("path");
    }
    const std::string stem = files[i].stem().string(), name = valid_utf8(stem);
    if (name != stem) c.warn("a file name is not UTF-8: its shape is called " + name);
    warn_of_bodies(c, files[i].filename().string(), found, scale);
    for (std::size_t k = 0; k < found.size(); ++k)
      bodies.push_back({found.size() == 1 ? name : fmt::format("{}_{}", name, k + 1), std::move(found[k])});
  }
  Shapes shapes;
  double triangles = 0, volume = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double n = bodies.size();
    for (auto& v : bodies[i].mesh.vertices) v *= scale;
    Shape shape = measure_shape(bodies[i].name, std::move(bodies[i].mesh), 1 / n,
                                c.work().part(0.5 + 0.5 * i / n, 0.5 + 0.5 * (i + 1) / n));
    shape.smooth = c.boolean("smooth");
    triangles += shape.mesh.triangles.size();
    volume += shape.volume / n;
    shapes.shapes.push_back(std::move(shape));
  }
  c.metric("shapes", shapes.shapes.size());
  c.metric("triangles", triangles);
  c.metric("volume", volume);
  c.output("shapes", std::move(shapes));
}

}  // namespace
}  // namespace terrazzo::load_mesh

namespace terrazzo {

NodeType load_mesh_node() {
  using namespace load_mesh;
  return NodeType("LoadMesh", 3)
      .doc_(
          "Reads particle shapes from OBJ, PLY, STL, OFF or glTF files. Each body in a file becomes a shape "
          "and must be watertight. Otherwise the node fails and lists the open or faulty edges, or closes "
          "the mesh if repair is true. With surface: true, each file becomes one shape, which may be open.")
      .output("shapes", "Shapes",
              "One shape per body, with the centroid at the origin, or per file, at its place, with surface: "
              "true; all with equal probability")
      .parameter(Parameter::input_path("path").doc_(
          "Mesh file: .obj, .ply, .stl, .off, .glb or .gltf. A glob loads several "
          "shapes."))
      .parameter(Parameter::number("scale", 1)
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Length of the file's unit. glTF files are in meters by definition; for them, the "
                           "length that one millimeter in the file stands for."))
      .parameter(Parameter::boolean("repair", false)
                     .doc_("Joins close vertices, drops degenerate and duplicate triangles, makes all "
                           "triangles face outward and fills holes. A warning lists the changes."))
      .parameter(
          Parameter::boolean("surface", false)
              .doc_("Reads each file as one surface for Bake, which may be open, at its place and with "
                    "the texture coordinates of .obj, .glb and .gltf files. It cannot be packed, since "
                    "it has no volume."))
      .parameter(Parameter::boolean("smooth", false)
                     .doc_("Pictures and .glb files show the mesh with interpolated normals."))
      .parameter(
          Parameter::optional_integer("max_triangles", "all")
              .range(4, 1e8)
              .doc_("Simplifies a mesh with more triangles to this number by collapsing edges, starting with "
                    "those that change the surface least. all: keeps the mesh as it is."))
      // A shape is named after its file. The action key includes the names of companion files, so renaming a
      // file changes the key.
      .companion_files_([](const std::filesystem::path& path) { return std::vector{path}; })
      .compute_(compute);
}

}  // namespace terrazzo
