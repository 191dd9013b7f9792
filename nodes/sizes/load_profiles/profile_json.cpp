#include "nodes/sizes/load_profiles/profile_json.h"

#include <fmt/format.h>

#include "nodes/common/io/json_input.h"

namespace terrazzo::load_profiles {
namespace {
using Json = nlohmann::json;

constexpr int kLargest = 1'000'000'000;  // of sections and classes

Profile profile_of(const JsonObject& o, View view) {
  Profile p;
  p.section = o.whole("section", 0, kLargest);
  p.cls = o.whole("class", 0, kLargest);
  p.area = o.number("area", JsonObject::kSmallest);
  p.centroid = o.vector<Vec2>("centroid");
  p.touches_border = o.boolean("touches_border");
  p.weight = o.number("weight", 0);
  p.confidence = o.number("confidence", 0, 1);
  p.color = o.vector<Vec3f>("color");
  if (view == View::Surface) p.whole = o.number("whole", p.area);
  if (!o.has("contour")) return p;
  const Json& contour = o.field("contour");
  if (!contour.is_array() || contour.size() < 3) o.fail("the field contour needs at least three points");
  for (const Json& point : contour) p.contour.push_back(o.vector<Vec2>("contour", point));
  return p;
}

View view_of(const JsonObject& all) {
  const std::string word = all.text("view");
  for (const View view : kViews)
    if (word == name_of(view)) return view;
  all.fail(fmt::format("has the view '{}', but a view is section, surface or filling", word));
}

}  // namespace

bool is_json(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '{';
}

Profiles read_profiles_json(const std::string& text, const std::string& file) {
  const JsonSource source{file, "use a .json file that Export wrote from profiles"};
  const Json json = parse_json(text, "profiles", source);
  const JsonObject all(json, source);
  Profiles out;
  out.observed_area = all.number("observed_area", 0);
  out.sections = all.whole("sections", 0, kLargest);
  out.classes = all.whole("classes", 0, kLargest);
  out.window = all.vector<Vec2>("window");
  out.binder_color = all.vector<Vec3f>("binder_color");
  out.area_fraction = all.number("area_fraction", 0, 1);
  if (all.has("view")) out.view = view_of(all);
  if (out.view == View::Surface) out.light = all.vector<Vec2>("light");
  for (const Json& j : all.list("profiles")) {
    const JsonObject one(j, source, fmt::format("profile {}: ", out.profiles.size()), "bad-profile");
    out.profiles.push_back(profile_of(one, out.view));
    const Profile& p = out.profiles.back();
    if (p.section >= out.sections || p.cls >= out.classes)
      one.fail(fmt::format("is in section {} and class {}, but there are {} sections and {} classes",
                           p.section, p.cls, out.sections, out.classes));
  }
  return out;
}

}  // namespace terrazzo::load_profiles
