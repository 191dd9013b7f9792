#include <fmt/format.h>

#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {

namespace {

// What the header says: "[ST][C][N][4][n]OFF". Geomview also reads files without a header.
struct OffHeader {
  std::uint64_t vertices;
  std::size_t numbers;  // of a vertex, without its color
};

OffHeader read_off_header(Words& words, std::uint64_t most) {
  std::string_view word = words.word_anywhere('#');
  OffHeader out{0, 3};
  if (!word.empty() && word.find_first_not_of("0123456789") != std::string_view::npos) {
    std::string_view letters = word;
    const auto take = [&](std::string_view prefix) {
      const bool there = letters.starts_with(prefix);
      if (there) letters.remove_prefix(prefix.size());
      return there;
    };
    if (take("ST")) out.numbers += 2;
    take("C");
    if (take("N")) out.numbers += 3;
    if (take("4") || take("n"))
      damaged("its vertices do not have three coordinates (" + printable(word) + ")");
    if (lowercase(letters) != "off") damaged("does not begin as an OFF file");
    word = words.word_anywhere('#');
    if (word == "BINARY")
      throw Error("unreadable-mesh", "binary OFF is not supported", "save it as ASCII OFF or as PLY");
  }
  out.vertices = count(word, most, words.line(), "the number of vertices");
  return out;
}

}  // namespace

// Geomview's format: a header such as "OFF", "COFF" or "NOFF", the counts, then one vertex or face per line.
// Everything after the three coordinates or the corners (normals, colors) is ignored.
PolygonSoup read_off(std::string_view text) {
  Words words(text);
  const auto [vertices, numbers] = read_off_header(words, text.size());
  const std::uint64_t faces =
      count(words.word_anywhere('#'), text.size(), words.line(), "the number of faces");

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
        polygon.push_back(count(w, 2147483647, words.line(), "a vertex index"));
      }
      require_corners(soup.polygons.size(), polygon.size());
      soup.polygons.push_back(std::move(polygon));
    }
  }
  return soup;
}

}  // namespace terrazzo::load_mesh
