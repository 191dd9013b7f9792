#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

// A corner is "v", "v/vt", "v//vn" or "v/vt/vn"; negative numbers count back from the last vertex.
int corner(std::string_view word, std::size_t vertices, int line) {
  const std::string_view first = word.substr(0, word.find('/'));
  std::int64_t n = 0;
  const auto [end, error] = std::from_chars(first.data(), first.data() + first.size(), n);
  if (error != std::errc() || end != first.data() + first.size() || n == 0)
    damaged(fmt::format("line {}: \"{}\" is not a vertex reference", line, printable(word)));
  const std::int64_t at = n > 0 ? n - 1 : static_cast<std::int64_t>(vertices) + n;
  // Vertices may follow the faces that use them, so read_mesh checks the upper bound at the end.
  if (at < 0 || at > std::numeric_limits<int>::max())
    throw Error("bad-mesh", fmt::format("line {}: the face refers to vertex {} of {}", line, n, vertices),
                "the file is damaged: export it again");
  return at;
}

// The coordinate of a corner, as a place in `vt` lines, or −1. A damaged one is ignored like other extras.
std::int64_t coordinate_of(std::string_view word, std::size_t before) {
  const std::size_t slash = word.find('/');
  if (slash == std::string_view::npos) return -1;
  const std::string_view second = word.substr(slash + 1, word.find('/', slash + 1) - slash - 1);
  std::int64_t n = 0;
  const auto [end, error] = std::from_chars(second.data(), second.data() + second.size(), n);
  if (error != std::errc() || end != second.data() + second.size() || n == 0) return -1;
  return n > 0 ? n - 1 : static_cast<std::int64_t>(before) + n;
}

// A damaged number is NaN, so that only faces that use it lose their coordinates.
float number_or_nan(std::string_view word) {
  return static_cast<float>(number_in(word).value_or(std::numeric_limits<double>::quiet_NaN()));
}

// Those of a `vt` line. v may be left out, and points up in a .obj file. Each line counts, also a damaged
// one, since faces refer to them by number.
Eigen::Vector2f texture_place(const std::vector<std::string_view>& line) {
  const float u = number_or_nan(line.size() > 1 ? line[1] : std::string_view());
  return {u, 1 - (line.size() > 2 ? number_or_nan(line[2]) : 0.0f)};
}

// Coordinates may follow the faces that use them.
void resolve_coordinates(PolygonSoup& soup, const std::vector<std::vector<std::int64_t>>& corners,
                         const std::vector<Eigen::Vector2f>& coordinates) {
  const auto usable = [&](std::int64_t at) {
    return at >= 0 && at < count_of(coordinates) && coordinates[at].allFinite();
  };
  for (const auto& polygon : corners) soup.without_uv += !std::all_of(polygon.begin(), polygon.end(), usable);
  if (soup.without_uv > 0) return;
  for (const auto& polygon : corners) {
    soup.uv.emplace_back();
    for (const std::int64_t at : polygon) soup.uv.back().push_back(coordinates[at]);
  }
}

// The words of the current line. A backslash at its end continues it.
void take_words(Words& words, std::vector<std::string_view>& found) {
  found.clear();
  for (std::string_view w = words.word();; w = words.word()) {
    if (w == "\\") {
      if (!words.next_line('#')) return;
    } else if (w.empty()) {
      return;
    } else if (w.ends_with('\\')) {
      found.push_back(w.substr(0, w.size() - 1));
      if (!words.next_line('#')) return;
    } else {
      found.push_back(w);
    }
  }
}

}  // namespace

PolygonSoup read_obj(std::string_view text, TextureCoordinates uv) {
  const bool textured = uv == TextureCoordinates::Read;
  PolygonSoup soup;
  Words words(text);
  std::vector<std::string_view> found;
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<std::vector<std::int64_t>> corners;
  while (words.next_line('#')) {
    take_words(words, found);
    if (found.empty()) continue;
    if (found[0] == "v") {
      if (found.size() < 4)
        damaged(fmt::format("line {}: a vertex has {} coordinates", words.line(), found.size() - 1));
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = coordinate(found[k + 1], words.line());
      soup.vertices.push_back(p);
    } else if (found[0] == "vt" && textured) {
      coordinates.push_back(texture_place(found));
    } else if (found[0] == "f" || found[0] == "fo") {  // "fo" is the old form of "f"
      std::vector<int> polygon;
      for (std::size_t k = 1; k < found.size(); ++k)
        polygon.push_back(corner(found[k], soup.vertices.size(), words.line()));
      require_corners(soup.polygons.size(), polygon.size());
      soup.polygons.push_back(std::move(polygon));
      if (!textured) continue;
      corners.emplace_back();
      for (std::size_t k = 1; k < found.size(); ++k)
        corners.back().push_back(coordinate_of(found[k], coordinates.size()));
    }
  }
  if (textured) resolve_coordinates(soup, corners, coordinates);
  return soup;
}

}  // namespace terrazzo::load_mesh
