#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/data/image.h"
#include "nodes/media/micrograph/recommend.h"
#include "runtime/context.h"

namespace terrazzo::try_route {
namespace {

void require_shown(const Image& image, const std::string& route, const Work& work) {
  const media::Recommendation better = media::recommend(image, work);
  if (better.phases != (route == "phases"))
    throw Error(
        better.phases ? "shows-phases" : "shows-particles",
        fmt::format("{} It is better taken for {}", better.why, better.phases ? "phases" : "particles"),
        fmt::format("to take it for {0} all the same, ask for '{0}'", route))
        .parameter("asked");
}

void compute(Context& c) {
  const std::string route = c.text("route"), asked = c.text("asked");
  if (asked != "auto" && asked != route)
    throw Error("not-asked", fmt::format("'{}' was asked for, not '{}'", asked, route)).parameter("asked");
  if (asked == "auto" && route != "exemplar") require_shown(c.input<Image>("image"), route, c.work());
  c.output("image", c.value("image"));
}

}  // namespace
}  // namespace terrazzo::try_route

namespace terrazzo {

NodeType try_route_node() {
  using namespace try_route;
  return NodeType("TryRoute", 1)
      .doc_(
          "Passes a photograph on if this way to a solid is to be tried; otherwise fails at once. Use it at "
          "the beginning of a subgraph that may fail.")
      .input("image", "Image", "Photograph")
      .output("image", "Image", "The same")
      .parameter(Parameter::choice("route", "particles", {"phases", "particles", "exemplar"})
                     .doc_("The way that follows: a solid of phases, of particles, or a texture like the "
                           "photograph"))
      .parameter(Parameter::choice("asked", "auto", {"auto", "phases", "particles", "exemplar"})
                     .doc_("The way that was asked for. auto: exemplar, and the one of phases and particles "
                           "that the photograph shows."))
      .compute_(compute);
}

}  // namespace terrazzo
