#include <fmt/format.h>

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

float number_or_nan(std::string_view word) {
  float out = std::numeric_limits<float>::quiet_NaN();
  std::from_chars(word.data(), word.data() + word.size(), out);
  return out;
}

// Coordinates may follow the faces that use them. The v of a .obj file points up.
std::vector<std::vector<Eigen::Vector2f>> resolved(const std::vector<std::vector<std::int64_t>>& corners,
                                                   const std::vector<Eigen::Vector2f>& coordinates) {
  std::vector<std::vector<Eigen::Vector2f>> out;
  for (const auto& polygon : corners) {
    out.emplace_back();
    for (const std::int64_t at : polygon) {
      if (at < 0 || at >= count_of(coordinates) || !coordinates[at].allFinite()) return {};
      out.back().emplace_back(coordinates[at].x(), 1 - coordinates[at].y());
    }
  }
  return out;
}

}  // namespace

PolygonSoup read_obj(std::string_view text) {
  PolygonSoup soup;
  Words words(text);
  std::vector<std::string_view> found;
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<std::vector<std::int64_t>> corners;
  while (words.next_line('#')) {
    found.clear();
    // A backslash at the end of a line continues it.
    for (std::string_view w = words.word();; w = words.word()) {
      if (w == "\\") {
        if (!words.next_line('#')) break;
      } else if (w.empty()) {
        break;
      } else if (w.ends_with('\\')) {
        found.push_back(w.substr(0, w.size() - 1));
        if (!words.next_line('#')) break;
      } else {
        found.push_back(w);
      }
    }
    if (found.empty()) continue;
    if (found[0] == "v") {
      if (found.size() < 4)
        damaged(fmt::format("line {}: a vertex has {} coordinates", words.line(), found.size() - 1));
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = coordinate(found[k + 1], words.line());
      soup.vertices.push_back(p);
    } else if (found[0] == "vt" && found.size() >= 3) {
      coordinates.emplace_back(number_or_nan(found[1]), number_or_nan(found[2]));
    } else if (found[0] == "f" || found[0] == "fo") {  // "fo" is the old form of "f"
      std::vector<int> polygon;
      corners.emplace_back();
      for (std::size_t k = 1; k < found.size(); ++k) {
        polygon.push_back(corner(found[k], soup.vertices.size(), words.line()));
        corners.back().push_back(coordinate_of(found[k], coordinates.size()));
      }
      require_corners(soup.polygons.size(), polygon.size());
      soup.polygons.push_back(std::move(polygon));
    }
  }
  soup.uv = resolved(corners, coordinates);
  return soup;
}

}  // namespace terrazzo::load_mesh
