#include "graph/node_type.h"
#include "nodes/packing/cells/request.h"
#include "nodes/packing/rigid/request.h"
#include "runtime/context.h"

namespace terrazzo::tessellate {
namespace {

void compute(Context& c) {
  using namespace tessellation;
  const auto& distribution = c.input<SizeDistribution>("distribution");
  const FillOptions options = read_fill(c, c.choice<Method>("method"));
  output_fill(c, distribution, fill_space(distribution, c.input<Shapes>("shapes"), options, c.work()));
}

}  // namespace
}  // namespace terrazzo::tessellate

namespace terrazzo {

NodeType tessellate_node() {
  using namespace tessellate;
  NodeType type("Tessellate", 8);
  type.doc_(
          "Fills a periodic box with particles of given volumes, for granite, breccia, gravel, metals and "
          "ceramics, which are denser than rigid particles can be packed. Each particle has its own shape.")
      .source_(
          "Lévy 2015; Bourne, Kok, Roper, Spanjer 2020 (laguerre); Jagnow, Dorsey, Rushmeier 2004, section "
          "4.1 "
          "(packing before growth)")
      .input("distribution", "SizeDistribution", "Number density of particles by size class")
      .input("shapes", "Shapes", "Shapes referenced by the distribution, as closed meshes")
      .optional_input("profiles", {"Profiles"},
                      "Profiles of the photograph, for the thickness of the binder between neighbors")
      .output("particles", "Particles", "The particles in the box [0, size)")
      .output("shapes", "Shapes", "One shape per particle")
      .output("table", "Table", "Class, volumes, size, surface and sphericity of each particle")
      .output("figure", "Image", "Histograms of size, sphericity and volume error")
      .parameter(
          Parameter::choice("method", "laguerre", {"laguerre", "grow"})
              .doc_("laguerre: convex cells with flat faces that have exactly the volumes of the "
                    "distribution; their shapes follow from their neighbors. grow: particles with the "
                    "given shapes are packed, and then enlarged into each other; their contacts become "
                    "flat. It reaches volume fractions of about 0.95."));
  packing::declare_population(type);
  tessellation::declare_fill(type);
  type.check_(tessellation::check_fill).compute_(compute);
  return type;
}

}  // namespace terrazzo
