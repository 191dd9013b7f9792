#include <fmt/format.h>

#include <charconv>
#include <limits>

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

}  // namespace

PolygonSoup read_obj(std::string_view text) {
  PolygonSoup soup;
  Words words(text);
  std::vector<std::string_view> found;
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
    } else if (found[0] == "f" || found[0] == "fo") {  // "fo" is the old form of "f"
      std::vector<int> polygon;
      for (std::size_t k = 1; k < found.size(); ++k)
        polygon.push_back(corner(found[k], soup.vertices.size(), words.line()));
      require_corners(soup.polygons.size(), polygon.size());
      soup.polygons.push_back(std::move(polygon));
    }
  }
  return soup;
}

}  // namespace terrazzo::load_mesh
