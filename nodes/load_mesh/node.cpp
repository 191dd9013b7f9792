#include <fmt/format.h>

#include "graph/node_type.h"
#include "graph/utf8.h"
#include "nodes/common/mesh.h"
#include "nodes/common/shape_measures.h"
#include "nodes/load_mesh/read_mesh.h"
#include "nodes/load_mesh/reduce.h"
#include "nodes/load_mesh/repair.h"
#include "runtime/context.h"

namespace terrazzo {

namespace {

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const auto& p : parts) text += (text.empty() ? "" : "; ") + p;
  return text;
}

Mesh solid_from(Context& c, const std::filesystem::path& path, const Work& work) {
  const std::string name = path.filename().string();
  const bool mend = c.boolean("repair");
  Mesh mesh = triangles_of(read_mesh(path, reading_of(c)), work);
  // Files that give each face corners of its own (texture seams, some STL writers) need no more than joining
  // equals.
  if (!mesh_faults(mesh).empty() || mesh_volume(mesh) <= 0) {
    Mesh welded = mesh;
    weld(welded, 0);
    if (mend || mesh_faults(welded).empty()) mesh = std::move(welded);
  }
  if (mend)
    if (const auto done = repair(mesh, work); !done.empty()) c.warn(name + ": " + joined(done));
  const auto faults = mesh_faults(mesh);
  if (!faults.empty())
    throw Error("open-mesh", fmt::format("{} is not watertight: {}", name, joined(faults)),
                mend ? "repair could not mend it: close it in a mesh editor"
                     : "set repair: true, or close it in a mesh editor")
        .parameter("path");
  if (!(mesh_volume(mesh) > 0))
    throw Error("inside-out", name + " has its inside out, or encloses nothing",
                mend ? "give a mesh with an extent in all three directions" : "set repair: true to turn it")
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
    if (name != stem) c.warn("a file's name is not UTF-8: its shape is called " + name);
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

NodeType load_mesh_node() {
  return NodeType("LoadMesh", 2)
      .doc_(
          "Particle shapes from OBJ, PLY, STL or OFF files. A mesh must be watertight; what is not is "
          "refused with the "
          "places of its faults, or mended.")
      .output("shapes", "Shapes", "one shape a file, of equal probabilities, centred at its centroid")
      .parameter(Parameter::input_path("path").doc_("mesh file; a glob gives several shapes"))
      .parameter(Parameter::number("scale", 1).unit_("mm").above(0).doc_("length of the file's unit"))
      .parameter(
          Parameter::boolean("repair", false)
              .doc_(
                  "join close vertices, drop degenerate and doubled triangles, turn all to face outwards and "
                  "fill holes; tells what it did"))
      .parameter(
          Parameter::with_keyword(ParameterKind::Int, "max_triangles", "all")
              .range(4, 1e8)
              .doc_("reduce a mesh with more triangles to this many, by collapsing the edges that move its "
                    "surface least; all: keep the mesh as it is"))
      // A shape is called after its file. Companions enter the key by name, so a renamed file gives another
      // key.
      .companion_files_([](const std::filesystem::path& path) { return std::vector{path}; })
      .compute_(compute);
}

}  // namespace terrazzo
