#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "nodes/media/micrograph/recommend.h"
#include "runtime/context.h"

namespace terrazzo::try_route {
namespace {

// Percent of the crops. Textures of 17 photographs were recognized in 91 to 100 %.
constexpr double kConvincing = 90;

void require_shown(const Image& image, const std::string& route, const Work& work) {
  const media::Recommendation better = media::recommend(image, work);
  if (better.phases != (route == "phases"))
    throw Error(
        better.phases ? "shows-phases" : "shows-particles",
        fmt::format("{} It is better taken for {}", better.why, better.phases ? "phases" : "particles"),
        fmt::format("to take it for {0} all the same, ask for '{0}'", route))
        .parameter("asked");
}

// Share of uncertain profiles. 17 photographs of particles had at most 0.22, walls and wood 0.32 or more.
constexpr double kUncertain = 0.25;

void require_certain(const Profiles& found) {
  const auto& profiles = found.profiles;
  const auto uncertain =
      std::count_if(profiles.begin(), profiles.end(), [](const Profile& p) { return p.confidence < 0.5; });
  if (static_cast<double>(uncertain) > kUncertain * static_cast<double>(profiles.size()))
    throw Error("shows-no-particles",
                fmt::format("{} of {} profiles are uncertain, so the photograph hardly shows particles",
                            uncertain, profiles.size()),
                "to take it for particles all the same, ask for 'particles'")
        .parameter("asked");
}

// A texture keeps less of the material than phases or particles. So it is tried only where there are none, or
// where the observers recognize most of the particles' picture.
void require_wanted(Context& c) {
  if (c.has("phases"))
    throw Error("not-wanted", "there is a solid of phases, which keeps more of the material than a texture",
                "to make a texture all the same, ask for 'exemplar'")
        .parameter("asked");
  const Table* observers = c.optional<Table>("observers");
  if (observers == nullptr || observers->rows.empty()) return;
  double recognized = 0;
  for (std::size_t row = 0; row < observers->rows.size(); ++row)
    recognized = std::max(recognized, observers->number(row, "accuracy %"));
  if (recognized < kConvincing)
    throw Error("not-wanted",
                fmt::format("of the particles' picture, the observers recognize {:.0f} % of the crops; "
                            "a texture is tried from {:.0f} % on",
                            recognized, kConvincing),
                "to make a texture all the same, ask for 'exemplar'")
        .parameter("asked");
}

void compute(Context& c) {
  const std::string route = c.text("route"), asked = c.text("asked");
  if (asked != "auto" && asked != route)
    throw Error("not-asked", fmt::format("'{}' was asked for, not '{}'", asked, route)).parameter("asked");
  if (asked == "auto") {
    if (route == "exemplar")
      require_wanted(c);
    else
      require_shown(c.input<Image>("image"), route, c.work());
    if (const Profiles* found = c.optional<Profiles>("profiles")) require_certain(*found);
  }
  c.output("image", c.value("image"));
}

}  // namespace
}  // namespace terrazzo::try_route

namespace terrazzo {

NodeType try_route_node() {
  using namespace try_route;
  return NodeType("TryRoute", 2)
      .doc_(
          "Passes a photograph on if this way to a solid is to be tried; otherwise fails at once. Use it at "
          "the beginning of a subgraph that may fail.")
      .input("image", "Image", "Photograph")
      .optional_input("profiles", {"Profiles"}, "particles: those that Segment found")
      .optional_input("phases", {"Volume"}, "exemplar: a solid of phases, which is preferred")
      .optional_input("observers", {"Table"},
                      "exemplar: `table` of TextureObserver, for the photograph and the particles' picture")
      .output("image", "Image", "The same")
      .parameter(Parameter::choice("route", "particles", {"phases", "particles", "exemplar"})
                     .doc_("The way that follows: a solid of phases, of particles, or a texture like the "
                           "photograph"))
      .parameter(Parameter::choice("asked", "auto", {"auto", "phases", "particles", "exemplar"})
                     .doc_("The way that was asked for. auto: the one of phases and particles that the "
                           "photograph shows; exemplar if there is no solid of phases, and the observers "
                           "recognize at least 90 % of the crops of the particles' picture."))
      .compute_(compute);
}

}  // namespace terrazzo
