#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/compare/choose_solid/choice.h"
#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "runtime/context.h"

namespace terrazzo::choose_solid {
namespace {

const std::vector<std::string> kRoutes{"phases", "particles", "exemplar"};

// A solid counts if all three of its inputs are there.
Route route_of(Context& c, const std::string& name) {
  const int parts = c.has(name) + c.has(name + "_block") + c.has(name + "_volume");
  Route out{name, parts == 3, {}, {}};
  if (parts == 1 || parts == 2)
    c.warn(
        fmt::format("there is only a part of the solid of {0}, which needs the inputs '{0}', '{0}_block' and "
                    "'{0}_volume'",
                    name));
  if (const Table* observers = c.optional<Table>(name + "_observers"); observers && out.reached)
    read_observers(*observers, out);
  return out;
}

Table table_of(const std::vector<Route>& routes, const Choice& choice) {
  Table out;
  out.columns = {"route", "solid", "recognized %", "standard error %", "chosen", "why"};
  const auto cell = [](const std::optional<double>& x) {
    return x ? Table::Cell(*x) : Table::Cell(std::string());
  };
  for (std::size_t k = 0; k < routes.size(); ++k)
    out.rows.push_back({routes[k].name, routes[k].reached ? "yes" : "no", cell(routes[k].accuracy),
                        cell(routes[k].error), k == choice.route ? "yes" : "no",
                        k == choice.route ? choice.why : ""});
  return out;
}

void compute(Context& c) {
  std::vector<Route> routes;
  for (const auto& name : kRoutes) routes.push_back(route_of(c, name));
  const std::string route = c.text("route");
  const Choice choice = route == "auto" ? choose(routes) : take(routes, route);
  const std::string& name = kRoutes[choice.route];
  c.metric("route", static_cast<double>(choice.route));
  c.output("picture", c.value(name));
  c.output("block", c.value(name + "_block"));
  c.output("volume", c.value(name + "_volume"));
  c.output("table", table_of(routes, choice));
}

}  // namespace
}  // namespace terrazzo::choose_solid

namespace terrazzo {

NodeType choose_solid_node() {
  using namespace choose_solid;
  NodeType type("ChooseSolid", 1);
  type.doc_(
      "Keeps one of several solids made from the same photograph: of phases, of particles, or a texture like "
      "the photograph. Routes that failed count as not connected.");
  for (const auto& name : kRoutes)
    type.optional_input(name, {"Image"}, "Picture of the solid of " + name + ", as the photograph shows it")
        .optional_input(name + "_block", {"Image"}, "Picture of a block of it")
        .optional_input(name + "_volume", {"Volume"}, "Its voxels")
        .optional_input(name + "_observers", {"Table"},
                        "`table` of TextureObserver, for the photograph and the picture");
  return type.output("volume", "Volume", "Voxels of the solid that is kept")
      .output("picture", "Image", "Its picture")
      .output("block", "Image", "Picture of its block")
      .output(
          "table", "Table",
          "One row per solid: whether it exists, how many crops the observers recognize, and why one is kept")
      .parameter(Parameter::choice("route", "auto", {"auto", "phases", "particles", "exemplar"})
                     .doc_("The solid to keep. auto: phases if there are any; else the one whose picture the "
                           "observers recognize least, and particles if that difference is below two "
                           "standard errors."))
      .compute_(compute);
}

}  // namespace terrazzo
