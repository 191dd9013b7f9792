#include <fmt/format.h>

#include "nodes/load_mesh/formats.h"
#include "nodes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {

// Geomview's format: a header such as "OFF", "COFF" or "NOFF", the counts, then one vertex or face per line.
// Everything after the three coordinates or the corners (normals, colors) is ignored.
PolygonSoup read_off(std::string_view text) {
  Words words(text);
  const std::string header(words.word_anywhere('#'));
  if (!header.ends_with("OFF")) damaged("does not begin as an OFF file");
  if (header.find_first_of("4n") != std::string::npos)
    damaged("its vertices do not have three coordinates (" + printable(header) + ")");
  const std::string_view first = words.word_anywhere('#');
  if (first == "BINARY")
    throw Error("unreadable-mesh", "binary OFF is not supported", "save it as ASCII OFF or as PLY");
  const std::uint64_t vertices = count(first, text.size(), words.line(), "the number of vertices");
  const std::uint64_t faces =
      count(words.word_anywhere('#'), text.size(), words.line(), "the number of faces");

  const std::size_t numbers =
      3 + (header.find('N') != std::string::npos ? 3 : 0) + (header.find("ST") != std::string::npos ? 2 : 0);
  PolygonSoup soup;
  while (soup.vertices.size() < vertices || soup.polygons.size() < faces) {
    if (!words.next_line('#'))
      damaged(fmt::format("it ends after {} of {} vertices and {} of {} faces", soup.vertices.size(),
                          vertices, soup.polygons.size(), faces));
    std::string_view w = words.word();
    if (w.empty()) continue;
    if (soup.vertices.size() < vertices) {
      Vec3 p;
      std::size_t n = 0;
      for (; !w.empty(); w = words.word(), ++n) {
        const double v = coordinate(w, words.line());
        if (n < 3) p[static_cast<int>(n)] = v;
      }
      if (n < numbers)
        damaged(fmt::format("line {}: the vertex has {} of {} numbers", words.line(), n, numbers));
      soup.vertices.push_back(p);
    } else {
      const std::uint64_t corners = count(w, text.size(), words.line(), "the number of corners");
      std::vector<int> polygon;
      for (std::uint64_t k = 0; k < corners; ++k) {
        w = words.word();
        if (w.empty())
          damaged(fmt::format("line {}: the face has {} of {} corners", words.line(), k, corners));
        polygon.push_back(static_cast<int>(count(w, 2147483647, words.line(), "a vertex index")));
      }
      require_corners(soup.polygons.size(), polygon.size());
      soup.polygons.push_back(std::move(polygon));
    }
  }
  return soup;
}

}  // namespace terrazzo::load_mesh
