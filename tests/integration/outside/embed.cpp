// An external program that opens a graph, edits it and evaluates it twice.
#include <iostream>

#include "nodes/data/shapes.h"
#include "nodes/register_nodes.h"
#include "runtime/session.h"

int main() {
  terrazzo::Registry registry;
  terrazzo::register_nodes(registry);
  terrazzo::ValueTypes types;
  terrazzo::register_value_types(types);
  terrazzo::Session session(registry, types);
  const auto found = session.open_text("terrazzo: 1\nnodes:\n  stone: {type: Shape, params: {kind: box}}\n",
                                       "embedded.yaml");
  for (const auto& d : found) std::cerr << d.text() << '\n';
  if (terrazzo::has_errors(found)) return 1;
  const auto faces = [&] {
    return session.value("stone.shapes").as<terrazzo::Shapes>().shapes.at(0).mesh.triangles.size();
  };
  std::cout << faces() << ' ';
  session.set("stone.kind", "tetrahedron");
  std::cout << faces() << '\n';
}
