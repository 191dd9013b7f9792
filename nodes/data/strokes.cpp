#include "nodes/data/strokes.h"

#include <fmt/format.h>

#include <cmath>

#include "nodes/data/json.h"

namespace terrazzo {

void check_stroke(const Stroke& s) {
  const auto bad = [](const std::string& what) {
    return Error("bad-stroke", what,
                 "a stroke needs points in pixels and a radius above 0, or outlines of an area");
  };
  constexpr double kMost = 1e6;
  if (!(s.radius >= 0 && s.radius <= kMost)) throw bad(fmt::format("the radius of a stroke is {}", s.radius));
  if (!s.area && s.radius <= 0) throw bad("the radius of a line is 0");
  if (s.parts.empty()) throw bad("a stroke has no points");
  if (!s.area && s.parts.size() != 1)
    throw bad(fmt::format("a line has {} parts instead of one", s.parts.size()));
  for (const auto& part : s.parts) {
    if (part.empty()) throw bad("a stroke has no points");
    if (s.area && part.size() < 3)
      throw bad(fmt::format("the outline of an area has {} points; it needs at least 3", part.size()));
    for (const auto& p : part)
      if (!(std::abs(p.x()) <= kMost && std::abs(p.y()) <= kMost))
        throw bad(fmt::format("a stroke has the invalid point ({}, {})", p.x(), p.y()));
  }
}

namespace {

void encode(const Strokes& v, Writer& w) {
  w.pod<std::uint64_t>(v.strokes.size());
  for (const auto& s : v.strokes) {
    w.pod(s.radius);
    w.pod<std::uint8_t>(s.area);
    w.pod<std::uint64_t>(s.parts.size());
    for (const auto& part : s.parts) w.raw_array(part);
  }
}

Strokes decode_strokes(Reader& r) {
  Strokes v;
  v.strokes.resize(r.count(8 + 1 + 8));
  for (auto& s : v.strokes) {
    s.radius = r.pod<double>();
    s.area = r.pod<std::uint8_t>() != 0;
    s.parts.resize(r.count(8));
    for (auto& part : s.parts) part = r.raw_array<Vec2>();
  }
  return v;
}

nlohmann::json describe(const Strokes& v) {
  nlohmann::json out = nlohmann::json::array();
  for (const auto& s : v.strokes) {
    nlohmann::json parts = nlohmann::json::array();
    for (const auto& part : s.parts) {
      nlohmann::json points = nlohmann::json::array();
      for (const auto& p : part) points.push_back(json_of(p));
      parts.push_back(std::move(points));
    }
    nlohmann::json one = {{"area", s.area}, {"radius", s.radius}};
    if (parts.size() == 1)
      one["points"] = parts[0];
    else
      one["parts"] = std::move(parts);
    out.push_back(std::move(one));
  }
  return {{"strokes", std::move(out)}};
}

}  // namespace

template <>
const ValueType& value_type<Strokes>() {
  static const ValueType type = make_value_type<Strokes>("Strokes", "Strokes of a nib or brush on an image",
                                                         encode, decode_strokes, describe);
  return type;
}

}  // namespace terrazzo
