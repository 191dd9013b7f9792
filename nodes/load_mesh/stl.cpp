#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "nodes/load_mesh/formats.h"
#include "nodes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

// Assigns one vertex to equal positions, numbered by first use.
class Corners {
 public:
  explicit Corners(PolygonSoup& soup) : soup_(soup) {}
  int operator()(const Vec3& p) {
    // −0 + 0 is 0, so both become the same key.
    const auto [it, fresh] =
        at_.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, static_cast<int>(at_.size()));
    if (fresh) soup_.vertices.push_back(p);
    return it->second;
  }

 private:
  PolygonSoup& soup_;
  std::map<std::array<double, 3>, int> at_;
};

constexpr std::size_t kHeader = 84, kTriangle = 50;

std::uint32_t promised(std::string_view bytes) {
  std::uint32_t n = 0;
  if (bytes.size() >= kHeader) std::memcpy(&n, bytes.data() + 80, sizeof n);
  return n;
}

PolygonSoup read_binary(std::string_view bytes) {
  if (bytes.size() < kHeader) damaged("is not an STL file");
  const std::uint32_t n = promised(bytes);
  if ((bytes.size() - kHeader) / kTriangle < n)
    damaged(fmt::format("its header says {} triangles, but the file ends after {}", n,
                        (bytes.size() - kHeader) / kTriangle));
  PolygonSoup soup;
  Corners corner(soup);
  for (std::size_t t = 0; t < n; ++t) {
    float f[9];
    std::memcpy(f, bytes.data() + kHeader + kTriangle * t + 12, sizeof f);
    std::vector<int> polygon(3);
    for (int k = 0; k < 3; ++k) {
      const Vec3 p(f[3 * k], f[3 * k + 1], f[3 * k + 2]);
      if (!p.allFinite())
        throw Error("bad-mesh", fmt::format("triangle {} has a corner that is not finite", t),
                    "the file is damaged: export it again");
      polygon[k] = corner(p);
    }
    soup.polygons.push_back(std::move(polygon));
  }
  return soup;
}

PolygonSoup read_ascii(std::string_view text) {
  PolygonSoup soup;
  Corners corner(soup);
  Words words(text);
  std::vector<int> polygon;
  bool open = false, ended = false;
  while (words.next_line()) {
    const std::string_view w = words.word();
    if (w == "solid") {
      ended = false;
    } else if (w == "vertex") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = coordinate(words.word(), words.line());
      polygon.push_back(corner(p));
    } else if (w == "facet" || w == "endfacet") {
      if (open == (w == "facet")) damaged(fmt::format("line {}: a facet is not closed", words.line()));
      open = !open;
      if (!open) {
        require_corners(soup.polygons.size(), polygon.size());
        soup.polygons.push_back(std::move(polygon));
      }
      polygon.clear();
    } else if (w == "endsolid") {
      ended = !open;
    } else if (!w.empty() && w != "outer" && w != "endloop") {
      damaged(fmt::format("line {}: unknown keyword \"{}\"", words.line(), printable(w)));
    }
  }
  if (!ended) damaged("the file ends without \"endsolid\"");
  return soup;
}

}  // namespace

// Binary files may also begin with "solid", so check the file size first.
PolygonSoup read_stl(std::string_view bytes) {
  const auto first = bytes.find_first_not_of(" \t\r\n");
  const bool solid = first != std::string_view::npos && bytes.substr(first).starts_with("solid");
  const bool fits =
      bytes.size() >= kHeader && bytes.size() == kHeader + kTriangle * std::size_t{promised(bytes)};
  return solid && !fits ? read_ascii(bytes) : read_binary(bytes);
}

}  // namespace terrazzo::load_mesh
