#include <fmt/format.h>

#include "graph/node_type.h"
#include "graph/utf8.h"
#include "nodes/common/geometry/mesh.h"
#include "nodes/common/geometry/reduce.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/load_mesh/read_mesh.h"
#include "nodes/load_mesh/repair.h"
#include "runtime/context.h"

namespace terrazzo::load_mesh {
namespace {

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const auto& p : parts) text += (text.empty() ? "" : "; ") + p;
  return text;
}

Mesh solid_from(Context& c, const std::filesystem::path& path, const Work& work) {
  const std::string name = path.filename().string();
  const bool may_repair = c.boolean("repair");
  Mesh mesh = triangles_of(read_mesh(path, reading_of(c)), work);
  // Some files repeat the vertices for each face (texture seams, some STL writers). Joining equal positions
  // closes them without a repair.
  if (!mesh_faults(mesh).empty() || mesh_volume(mesh) <= 0) {
    Mesh welded = mesh;
    weld(welded, 0);
    if (may_repair || mesh_faults(welded).empty()) mesh = std::move(welded);
  }
  if (may_repair)
    if (const auto done = repair(mesh, work); !done.empty()) c.warn(name + ": " + joined(done));
  const auto faults = mesh_faults(mesh);
  if (!faults.empty())
    throw Error("open-mesh", fmt::format("{} is not watertight: {}", name, joined(faults)),
                may_repair ? "repair could not close it: close it in a mesh editor"
                           : "set repair: true, or close it in a mesh editor")
        .parameter("path");
  if (!(mesh_volume(mesh) > 0))
    throw Error("inside-out", name + " is inside out or encloses no volume",
                may_repair ? "use a mesh with a volume" : "set repair: true to flip it")
        .parameter("path");
  if (c.keyword("max_triangles").empty())
    reduce_triangles(mesh, static_cast<std::size_t>(c.integer("max_triangles")), work);
  return mesh;
}

void compute(Context& c) {
  const auto& files = c.files("path");
  const double scale = c.number("scale");
  Shapes shapes;
  double triangles = 0, volume = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Work work = c.work().part(static_cast<double>(i) / files.size(), (i + 1.0) / files.size());
    Mesh mesh;
    try {
      mesh = solid_from(c, files[i], work);
    } catch (Error& e) {
      throw e.parameter("path");
    }
    for (auto& v : mesh.vertices) v *= scale;
    const std::string stem = files[i].stem().string(), name = valid_utf8(stem);
    if (name != stem) c.warn("a file name is not UTF-8: its shape is called " + name);
    Shape shape = measure_shape(name, std::move(mesh), 1.0 / files.size(), work);
    triangles += shape.mesh.triangles.size();
    volume += shape.volume / files.size();
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
  return NodeType("LoadMesh", 2)
      .doc_(
          "Reads particle shapes from OBJ, PLY, STL, OFF or glTF files. A mesh must be watertight. Otherwise "
          "the "
          "node fails and lists the open or faulty edges, or closes the mesh if repair is true.")
      .output("shapes", "Shapes",
              "One shape per file, all with equal probability, with the centroid at the origin")
      .parameter(Parameter::input_path("path").doc_(
          "Mesh file: .obj, .ply, .stl, .off, .glb or .gltf. A glob loads several "
          "shapes."))
      .parameter(Parameter::number("scale", 1)
                     .unit_("mm")
                     .above(0)
                     .doc_("Length of the file's unit. glTF files are in meters by definition; for them, the "
                           "length that one millimeter in the file stands for."))
      .parameter(Parameter::boolean("repair", false)
                     .doc_("Joins close vertices, drops degenerate and duplicate triangles, makes all "
                           "triangles face outward and fills holes. A warning lists the changes."))
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
