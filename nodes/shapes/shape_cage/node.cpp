#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/table.h"
#include "nodes/shapes/shape_cage/shape_cage.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

using namespace shape_cage;

std::vector<Move> moves_of(const NodeParameters& p) {
  std::vector<Move> out;
  for (const std::string& text : p.texts("moves")) out.push_back(parse_move(text));
  return out;
}

void check(const NodeParameters& p) { moves_of(p); }

void compute(Context& c) {
  Shapes shapes = c.input<Shapes>("shapes");
  if (shapes.shapes.empty())
    throw Error("no-shapes", "there are no shapes", "connect a set with at least one shape");
  const std::size_t number = c.integer("shape");
  if (number >= shapes.shapes.size())
    throw Error("no-such-shape",
                fmt::format("shape {} does not exist; there are {}", number, shapes.shapes.size()),
                fmt::format("write 0 to {}", shapes.shapes.size() - 1))
        .parameter("shape");
  Shape& shape = shapes.shapes[number];
  if (!shape.color.empty() || !shape.uv.empty())
    c.warn("the colors of shape '" + shape.name + "' are dropped, since the surface gets other vertices");
  Cage cage = fit_cage(shape.mesh, c.integer("vertices"), c.integer("iterations"), c.work().part(0, 0.8));
  c.metric("mean_error", cage.mean_error / shape.size());
  c.metric("largest_error", cage.largest_error / shape.size());
  move_vertices(cage.control, moves_of(c));

  Table table;
  table.columns = {"vertex", "x mm", "y mm", "z mm"};
  for (std::size_t v = 0; v < cage.control.vertices.size(); ++v) {
    const Vec3& p = cage.control.vertices[v];
    table.rows.push_back({double(v), p.x(), p.y(), p.z()});
  }
  Shape surface = measure_shape(shape.name, limit_surface(cage.control, c.integer("subdivision")),
                                shape.probability, c.work().part(0.8, 0.9));
  surface.cls = shape.cls;
  surface.smooth = true;
  shape = std::move(surface);
  Shapes control;
  control.shapes.push_back(measure_shape("cage", std::move(cage.control), 1, c.work().part(0.9, 1)));
  c.output("shapes", std::move(shapes));
  c.output("cage", std::move(control));
  c.output("table", std::move(table));
}

}  // namespace

NodeType shape_cage_node() {
  return NodeType("ShapeCage", 1)
      .doc_(
          "Edits a shape by moving vertices of a control cage: a coarse mesh whose subdivision surface is "
          "fitted to the shape")
      .source_("Jagnow, Dorsey, Rushmeier 2004, figure 9, whose authors edit NURBS; Loop 1987 by OpenSubdiv")
      .input("shapes", "Shapes", "Shapes, of which one is edited")
      .output("shapes", "Shapes", "The shapes, with the edited one in its place")
      .output("cage", "Shapes", "The control cage as a shape, after the moves")
      .output("table", "Table", "Control vertices after the moves, in the coordinates of the input shape")
      .parameter(Parameter::integer("shape", 0).range(0, 1e6).doc_("Number of the shape to edit, from 0"))
      .parameter(
          Parameter::integer("vertices", 40)
              .range(6, 400)
              .doc_("Number of control vertices. More fit the shape better, and each moves less of it. "
                    "Slightly more may remain."))
      .parameter(Parameter::texts("moves", {})
                     .count(0, 1000)
                     .doc_("Vertices to move: number, then x, y and z in mm, for example \"12 0.5 0 -1\""))
      .parameter(Parameter::integer("subdivision", 3)
                     .range(1, 5)
                     .doc_("Each triangle of the cage becomes 4^subdivision triangles"))
      .parameter(Parameter::integer("iterations", 30).range(0, 1000).doc_("Iterations of fitting the cage"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
