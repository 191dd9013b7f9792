#include "nodes/load_profiles/profile_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"

namespace terrazzo::load_profiles {
namespace {
using Json = nlohmann::json;

constexpr double kLargest = 1e9;  // of sections and classes

// An object of the file, and how messages name it.
class Object {
 public:
  Object(const Json& json, std::string file, std::string what = "", const char* code = "unreadable-file")
      : json_(json), file_(std::move(file)), what_(std::move(what)), code_(code) {
    if (!json.is_object()) fail("is not an object");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(code_, fmt::format("'{}': {}{}", file_, what_, what),
                "use a .json file that Export wrote from profiles")
        .parameter("path");
  }

  const Json& field(const char* name) const {
    const auto it = json_.find(name);
    if (it == json_.end()) fail(fmt::format("has no field {}", name));
    return *it;
  }
  bool has(const char* name) const { return json_.contains(name); }

  double number(const char* name, double least, double most) const {
    const Json& v = field(name);
    if (!v.is_number()) fail(fmt::format("the field {} is not a number", name));
    const auto n = v.get<double>();
    if (!(n >= least && n <= most))
      fail(fmt::format("the field {} is {:g}; it must be from {:g} to {:g}", name, n, least, most));
    return n;
  }
  int whole(const char* name) const {
    const double v = number(name, 0, kLargest);
    if (v != std::floor(v)) fail(fmt::format("the field {} is not a whole number", name));
    return static_cast<int>(v);
  }
  bool boolean(const char* name) const {
    const Json& v = field(name);
    if (!v.is_boolean()) fail(fmt::format("the field {} is not true or false", name));
    return v.get<bool>();
  }

  template <class V>
  V vector(const char* name, const Json& list) const {
    V out;
    if (!list.is_array() || list.size() != static_cast<std::size_t>(out.size()))
      fail(fmt::format("the field {} needs lists of {} numbers", name, out.size()));
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      const Json& v = list[static_cast<std::size_t>(i)];
      if (!v.is_number()) fail(fmt::format("the field {} contains something else than numbers", name));
      out[i] = static_cast<typename V::Scalar>(v.get<double>());
      if (!std::isfinite(out[i])) fail(fmt::format("the field {} has a number that is too large", name));
    }
    return out;
  }
  template <class V>
  V vector(const char* name) const {
    return vector<V>(name, field(name));
  }

 private:
  const Json& json_;
  std::string file_, what_;
  const char* code_;
};

Profile profile_of(const Object& o) {
  constexpr double most = std::numeric_limits<double>::max();
  Profile p;
  p.section = o.whole("section"), p.cls = o.whole("class");
  p.area = o.number("area", std::numeric_limits<double>::min(), most);
  p.centroid = o.vector<Vec2>("centroid");
  p.touches_border = o.boolean("touches_border");
  p.weight = o.number("weight", 0, most);
  p.confidence = o.number("confidence", 0, 1);
  p.color = o.vector<Vec3f>("color");
  if (!o.has("contour")) return p;
  const Json& contour = o.field("contour");
  if (!contour.is_array() || contour.size() < 3) o.fail("the field contour needs at least three points");
  for (const Json& point : contour) p.contour.push_back(o.vector<Vec2>("contour", point));
  return p;
}

}  // namespace

bool is_json(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '{';
}

// Each value takes 16 bytes, twice while its list grows; each list or object 80 more. A comma separates two.
double memory_to_read_json(const std::string& text) {
  return 64.0 * static_cast<double>(std::count(text.begin(), text.end(), ',') +
                                    std::count(text.begin(), text.end(), '[') +
                                    std::count(text.begin(), text.end(), '{')) +
         static_cast<double>(text.size());
}

Profiles read_profiles_json(const std::string& text, const std::string& file) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& e) {
    throw Error("unreadable-file", fmt::format("'{}' is not JSON: {}", file, printable(e.what())),
                "use a .json file that Export wrote from profiles")
        .parameter("path");
  }
  const auto inner = json.find("profiles");
  const Object all(inner != json.end() && inner->is_object() ? *inner : json, file, "the file ");
  Profiles out;
  out.observed_area = all.number("observed_area", 0, std::numeric_limits<double>::max());
  out.sections = all.whole("sections"), out.classes = all.whole("classes");
  out.window = all.vector<Vec2>("window");
  out.binder_color = all.vector<Vec3f>("binder_color");
  out.area_fraction = all.number("area_fraction", 0, 1);
  const Json& list = all.field("profiles");
  if (!list.is_array()) all.fail("has no list of profiles");
  for (const Json& j : list) {
    const Object one(j, file, fmt::format("profile {}: ", out.profiles.size()), "bad-profile");
    out.profiles.push_back(profile_of(one));
    const Profile& p = out.profiles.back();
    if (p.section >= out.sections || p.cls >= out.classes)
      one.fail(fmt::format("is in section {} and class {}, but there are {} sections and {} classes",
                           p.section, p.cls, out.sections, out.classes));
  }
  return out;
}

}  // namespace terrazzo::load_profiles
