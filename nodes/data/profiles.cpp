#include "nodes/data/profiles.h"

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/json.h"
#include "nodes/data/luminance.h"

namespace terrazzo {
namespace {

void encode(const Profiles& v, Writer& w) {
  w.pod(v.observed_area);
  w.pod(v.sections);
  w.pod(v.classes);
  w.bytes(v.window.data(), sizeof(double) * 2);
  w.bytes(v.binder_color.data(), sizeof(float) * 3);
  w.pod(v.area_fraction);
  w.pod<std::uint64_t>(v.profiles.size());
  for (const auto& p : v.profiles) {
    w.pod(p.section);
    w.pod(p.cls);
    w.pod(p.area);
    w.bytes(p.centroid.data(), sizeof(double) * 2);
    w.pod<std::uint8_t>(p.touches_border), w.pod(p.weight), w.pod(p.confidence);
    w.bytes(p.color.data(), sizeof(float) * 3);
    w.raw_array(p.contour);
  }
  if (v.fragments.empty() && v.view == View::Section) return;  // as before there were any
  w.pod<std::uint64_t>(v.fragments.size());
  for (const Fragment& f : v.fragments) {
    w.bytes(f.color.data(), sizeof(float) * 3);
    w.pod(f.area);
  }
  if (v.view == View::Section) return;  // as before there were others
  w.pod(static_cast<std::int32_t>(v.view));
  w.bytes(v.light.data(), sizeof(double) * 2);
  for (const auto& p : v.profiles) w.pod(p.whole);
}

Profiles decode_profiles(Reader& r) {
  Profiles v;
  v.observed_area = r.pod<double>();
  v.sections = r.pod<int>();
  v.classes = r.pod<int>();
  r.bytes(v.window.data(), sizeof(double) * 2);
  r.bytes(v.binder_color.data(), sizeof(float) * 3);
  v.area_fraction = r.pod<double>();
  v.profiles.resize(r.count(60));
  for (auto& p : v.profiles) {
    p.section = r.pod<int>();
    p.cls = r.pod<int>();
    p.area = r.pod<double>();
    r.bytes(p.centroid.data(), sizeof(double) * 2);
    p.touches_border = r.pod<std::uint8_t>() != 0;
    p.weight = r.pod<double>();
    p.confidence = r.pod<double>();
    r.bytes(p.color.data(), sizeof(float) * 3);
    p.contour = r.raw_array<Vec2>();
  }
  if (r.left() == 0) return v;
  v.fragments.resize(r.count(20));
  for (Fragment& f : v.fragments) {
    r.bytes(f.color.data(), sizeof(float) * 3);
    f.area = r.pod<double>();
  }
  if (r.left() == 0) return v;
  const auto view = r.pod<std::int32_t>();
  if (view < static_cast<std::int32_t>(View::Section) || view > static_cast<std::int32_t>(View::Filling))
    throw Error("damaged", "the stored value has an impossible view");
  v.view = static_cast<View>(view);
  r.bytes(v.light.data(), sizeof(double) * 2);
  for (auto& p : v.profiles) p.whole = r.pod<double>();
  return v;
}

nlohmann::json describe(const Profiles& v) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& p : v.profiles) {
    nlohmann::json j = {{"section", p.section},
                        {"class", p.cls},
                        {"area", p.area},
                        {"centroid", json_of(p.centroid)},
                        {"touches_border", p.touches_border},
                        {"weight", p.weight},
                        {"confidence", p.confidence},
                        {"color", json_of(p.color)}};
    if (p.whole > 0) j["whole"] = p.whole;
    if (!p.contour.empty()) {
      auto& c = j["contour"] = nlohmann::json::array();
      for (const auto& q : p.contour) c.push_back(json_of(q));
    }
    list.push_back(std::move(j));
  }
  nlohmann::json out = {{"observed_area", v.observed_area},
                        {"sections", v.sections},
                        {"classes", v.classes},
                        {"window", json_of(v.window)},
                        {"binder_color", json_of(v.binder_color)},
                        {"area_fraction", v.area_fraction},
                        {"profiles", std::move(list)}};
  if (v.view != View::Section) out["view"] = name_of(v.view);
  if (v.view == View::Surface) out["light"] = json_of(v.light);
  return out;
}

}  // namespace

bool shows_loose_stones(const Profiles& profiles) {
  if (profiles.view != View::Surface || profiles.profiles.empty()) return false;
  if (profiles.area_fraction >= kLooseCover) return true;
  std::vector<float> stones;
  for (const Profile& p : profiles.profiles) stones.push_back(luminance_of(p.color));
  const auto middle = stones.begin() + static_cast<std::ptrdiff_t>(stones.size() / 2);
  std::nth_element(stones.begin(), middle, stones.end());
  return luminance_of(profiles.binder_color) < kShadow * *middle;
}

const char* name_of(View view) {
  return view == View::Surface ? "surface" : view == View::Filling ? "filling" : "section";
}

template <>
const ValueType& value_type<Profiles>() {
  static const ValueType type = make_value_type<Profiles>(
      "Profiles", "Profiles of particles in plane sections, or their outlines seen from outside", encode,
      decode_profiles, describe);
  return type;
}

}  // namespace terrazzo
