#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <string_view>

#include "graph/text/read_number.h"
#include "nodes/cooccurrence/load_strokes/stroke_files.h"
#include "nodes/cooccurrence/load_strokes/svg_path.h"

namespace terrazzo::load_strokes {
namespace {

using Affine = Eigen::Affine2d;

Error bad(const std::string& what) {
  return Error("bad-strokes-file", what, "save the drawing as plain SVG with paths in pixels");
}

// A length in user units; units other than px are converted at SVG's 96 px per inch. Returns `none` for
// percentages and invalid text.
double length(std::string_view text, double none) {
  const auto v = take_number(text);
  static const std::map<std::string_view, double> units = {
      {"", 1}, {"px", 1}, {"pt", 96.0 / 72}, {"pc", 16}, {"in", 96}, {"cm", 96 / 2.54}, {"mm", 96 / 25.4}};
  const auto unit = units.find(text.substr(0, text.find_last_not_of(" \t\r\n") + 1));
  return !v || !std::isfinite(*v) || unit == units.end() ? none : *v * unit->second;
}

// The numbers of a list, up to the first that is none. A sign separates them, too.
std::vector<double> numbers(std::string_view text) {
  std::vector<double> out;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n,"), text.size()));
    const auto v = take_number(text);
    if (!v || !std::isfinite(*v)) return out;
    out.push_back(*v);
  }
}

Affine transform_of(const std::string& text) {
  Affine out = Affine::Identity();
  for (std::size_t at = 0;;) {
    const auto open = text.find('(', at), close = text.find(')', at);
    if (open == std::string::npos || close == std::string::npos || close < open) break;
    std::string name = text.substr(at, open - at);
    name.erase(0, name.find_first_not_of(" \t\r\n,"));
    while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back()))) name.pop_back();
    const auto v = numbers(text.substr(open + 1, close - open - 1));
    const auto deg = [](double d) { return d * M_PI / 180; };
    Affine t = Affine::Identity();
    if (name == "matrix" && v.size() == 6)
      t.matrix() << v[0], v[2], v[4], v[1], v[3], v[5], 0, 0, 1;
    else if (name == "translate" && !v.empty())
      t.translate(Vec2(v[0], v.size() > 1 ? v[1] : 0));
    else if (name == "scale" && !v.empty())
      t.scale(Vec2(v[0], v.size() > 1 ? v[1] : v[0]));
    else if (name == "rotate" && v.size() == 3)
      t.translate(Vec2(v[1], v[2])).rotate(deg(v[0])).translate(Vec2(-v[1], -v[2]));
    else if (name == "rotate" && !v.empty())
      t.rotate(deg(v[0]));
    else if (name == "skewX" && !v.empty())
      t.matrix()(0, 1) = std::tan(deg(v[0]));
    else if (name == "skewY" && !v.empty())
      t.matrix()(1, 0) = std::tan(deg(v[0]));
    else
      throw bad(fmt::format("cannot read the transform '{}'", printable(text)));
    out = out * t;
    at = close + 1;
  }
  return out;
}

struct Style {
  std::string stroke = "none", fill = "black", width = "1", display = "inline";
};

void take(Style& s, const std::string& name, const std::string& value) {
  if (value == "inherit") return;
  if (name == "stroke") s.stroke = value;
  if (name == "fill") s.fill = value;
  if (name == "stroke-width") s.width = value;
  if (name == "display" || name == "visibility") s.display = value;
}

Style style_of(Style s, const pugi::xml_node& n) {
  for (const auto& a : n.attributes()) take(s, a.name(), a.value());
  for (std::string_view rest = n.attribute("style").value(); !rest.empty();) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string entry(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const auto colon = entry.find(':');
    if (colon == std::string::npos) continue;
    const auto clean = [](std::string t) {
      t.erase(0, t.find_first_not_of(" \t\r\n"));
      while (!t.empty() && std::isspace(static_cast<unsigned char>(t.back()))) t.pop_back();
      return t;
    };
    take(s, clean(entry.substr(0, colon)), clean(entry.substr(colon + 1)));
  }
  return s;
}

// The subpaths of one element, in the element's own units.
std::vector<std::vector<Vec2>> outlines_of(const pugi::xml_node& n, double tolerance, std::size_t most) {
  const std::string name = n.name();
  const auto value = [&](const char* a) { return length(n.attribute(a).value(), 0); };
  if (name == "path") {
    std::string broken;
    auto out = read_path(n.attribute("d").value(), tolerance, broken, most);
    if (!broken.empty()) throw bad(broken);
    return out;
  }
  if (name == "polyline" || name == "polygon") {
    const auto v = numbers(n.attribute("points").value());
    std::vector<Vec2> points;
    for (std::size_t i = 0; i + 1 < v.size(); i += 2) points.emplace_back(v[i], v[i + 1]);
    if (points.empty()) return {};
    if (name == "polygon") points.push_back(points[0]);
    return {points};
  }
  if (name == "line") return {{Vec2(value("x1"), value("y1")), Vec2(value("x2"), value("y2"))}};
  if (name == "rect") {
    const Vec2 a(value("x"), value("y")), b = a + Vec2(value("width"), value("height"));
    return {{a, Vec2(b.x(), a.y()), b, Vec2(a.x(), b.y()), a}};
  }
  if (name == "circle" || name == "ellipse") {
    const Vec2 c(value("cx"), value("cy")),
        r = name == "circle" ? Vec2::Constant(value("r")) : Vec2(value("rx"), value("ry"));
    if (r.minCoeff() <= 0) return {};
    const Vec2 left(c.x() - r.x(), c.y()), right(c.x() + r.x(), c.y());
    std::vector<Vec2> points{left};
    for (const auto& p : arc_points(left, r, 0, false, true, right, tolerance)) points.push_back(p);
    for (const auto& p : arc_points(right, r, 0, false, true, left, tolerance)) points.push_back(p);
    return {points};
  }
  return {};
}

void collect(const pugi::xml_node& parent, const Affine& outer, const Style& inherited, int depth,
             std::size_t& left, Strokes& out) {
  if (depth > 200) throw bad("groups are nested more than 200 levels deep");
  for (const auto& n : parent.children()) {
    const std::string name = n.name();
    if (n.type() != pugi::node_element || name == "defs" || name == "symbol" || name == "clipPath" ||
        name == "mask" || name == "marker" || name == "pattern")
      continue;
    const Affine t = outer * transform_of(n.attribute("transform").value());
    const Style s = style_of(inherited, n);
    if (s.display == "none" || s.display == "hidden") continue;
    const double grown = std::sqrt(std::abs(t.linear().determinant()));
    auto outlines = outlines_of(n, 0.1 / std::max(grown, 1e-9), left);
    std::size_t points = 0;
    for (const auto& line : outlines) points += line.size();
    if (points > left)
      throw Error("too-large", "the drawing has more points than fit in memory", "simplify the drawing");
    left -= points;
    for (auto& line : outlines)
      for (auto& p : line) p = t * p;
    const double radius = s.stroke == "none" ? 0 : length(s.width, 1) * grown / 2;
    if (radius > 0) {
      for (auto& line : outlines)
        if (!line.empty()) out.strokes.push_back({{std::move(line)}, radius, false});
    } else if (s.fill != "none") {
      Stroke area;
      area.area = true;
      for (auto& line : outlines) {
        if (line.size() > 1 && line.front() == line.back()) line.pop_back();
        if (line.size() >= 3) area.parts.push_back(std::move(line));
      }
      if (!area.parts.empty()) out.strokes.push_back(std::move(area));
    }
    collect(n, t, s, depth + 1, left, out);
  }
}

}  // namespace

Strokes read_svg(const std::filesystem::path& file, const Reading& reading) {
  // Covers the text and the document, whose smallest element has four characters and uses 64 bytes.
  const std::string text = read_whole(file, reading);
  require_memory(20.0 * text.size(), reading.memory, "the drawing '" + file.string() + "'");
  pugi::xml_document document;
  const auto result = document.load_buffer(text.data(), text.size());
  if (!result) throw bad(fmt::format("not valid XML: {} at byte {}", result.description(), result.offset));
  const pugi::xml_node svg = document.child("svg");
  if (!svg) throw bad("the file contains no <svg> element");
  Affine view = Affine::Identity();
  const auto box = numbers(svg.attribute("viewBox").value());
  if (box.size() == 4 && box[2] > 0 && box[3] > 0) {
    const double w = length(svg.attribute("width").value(), box[2]),
                 h = length(svg.attribute("height").value(), box[3]);
    // The default of preserveAspectRatio: as large as fits, centered.
    const double by = std::min(w / box[2], h / box[3]);
    view.translate(Vec2((w - by * box[2]) / 2, (h - by * box[3]) / 2))
        .scale(by)
        .translate(Vec2(-box[0], -box[1]));
  }
  Strokes out;
  // A point may be copied twice while its list grows.
  std::size_t left = reading.memory / (4 * sizeof(Vec2));
  collect(svg, view, {}, 0, left, out);
  for (const auto& s : out.strokes) check_stroke(s);
  return out;
}

}  // namespace terrazzo::load_strokes
