#include "nodes/common/io/stroke_text.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <string_view>
#include <vector>

namespace terrazzo::strokes {
namespace {

std::string_view trimmed(std::string_view s) {
  const auto from = s.find_first_not_of(" \t\r\n"), to = s.find_last_not_of(" \t\r\n");
  return from == std::string_view::npos ? std::string_view() : s.substr(from, to - from + 1);
}

std::vector<std::string_view> split(std::string_view s, char by) {
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at <= s.size();) {
    const auto end = std::min(s.find(by, at), s.size());
    out.push_back(trimmed(s.substr(at, end - at)));
    at = end + 1;
  }
  return out;
}

bool number(std::string_view s, double& out) {
  const auto r = std::from_chars(s.data(), s.data() + s.size(), out);
  return r.ec == std::errc() && r.ptr == s.data() + s.size() && !s.empty();
}

Error bad(const std::string& text, const std::string& what) {
  const std::string shown = text.size() > 60 ? text.substr(0, 57) + "..." : text;
  return Error("bad-stroke", fmt::format("stroke '{}': {}", shown, what),
               "write a radius and points, as in '6: 10 20, 30 40', or 'area: 0 0, 9 0, 5 8'");
}

}  // namespace

Stroke read_stroke(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) throw bad(text, "':' is missing after the radius");
  Stroke s;
  const std::string_view head = trimmed(std::string_view(text).substr(0, colon));
  if (head == "area")
    s.area = true;
  else if (!number(head, s.radius))
    throw bad(text, fmt::format("'{}' is not a radius", head));
  for (const auto outline : split(std::string_view(text).substr(colon + 1), ';')) {
    auto& part = s.parts.emplace_back();
    for (const auto point : split(outline, ',')) {
      const auto gap = point.find_first_of(" \t\r\n");
      Vec2 p;
      if (gap == std::string_view::npos || !number(point.substr(0, gap), p.x()) ||
          !number(trimmed(point.substr(gap)), p.y()))
        throw bad(text, fmt::format("'{}' is not a point", point));
      part.push_back(p);
    }
  }
  try {
    check_stroke(s);
  } catch (const Error& e) {
    throw bad(text, e.diagnostic().message);
  }
  return s;
}

std::string write_stroke(const Stroke& s) {
  std::string out = s.area ? "area:" : fmt::format("{}:", s.radius);
  for (std::size_t i = 0; i < s.parts.size(); ++i) {
    if (i > 0) out += ";";
    for (std::size_t k = 0; k < s.parts[i].size(); ++k)
      out += fmt::format("{} {} {}", k > 0 ? "," : "", s.parts[i][k].x(), s.parts[i][k].y());
  }
  return out;
}

}  // namespace terrazzo::strokes
