#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "nodes/data/indices.h"
#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

// Assigns one vertex to equal positions, numbered by first use.
class Corners {
 public:
  explicit Corners(PolygonSoup& soup) : soup_(soup) {}
  int operator()(const Vec3& p) {
    // −0 + 0 is 0, so both become the same key.
    const auto [it, fresh] = at_.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, count_of(at_));
    if (fresh) soup_.vertices.push_back(p);
    return it->second;
  }

 private:
  PolygonSoup& soup_;
  std::map<std::array<double, 3>, int> at_;
};

constexpr std::size_t kHeader = 84, kTriangle = 50;

PolygonSoup read_binary(std::string_view bytes, const Reading& reading) {
  if (bytes.size() < kHeader) damaged("is not an STL file");
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, sizeof n);
  const std::size_t body = bytes.size() - kHeader;
  if (body / kTriangle < n || n == 0)
    damaged(fmt::format("its header says {} triangles, but the file holds {}", n, body / kTriangle));
  if (body > kTriangle * n)
    reading.warn(fmt::format("its header says {} triangles; the {} bytes behind them are ignored", n,
                             body - kTriangle * n));
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

// The words of an ASCII file in any case and on any number of lines. The normals are ignored; some writers
// leave them out.
class AsciiReader {
 public:
  explicit AsciiReader(std::string_view text) : words_(text) {}

  PolygonSoup read() {
    while (words_.next_line() && words_.word().empty()) {
    }  // up to the line of "solid" and any name
    while (words_.next_line())
      for (std::string_view w = words_.word(); !w.empty(); w = words_.word())
        if (!take(w)) break;
    if (!ended_) damaged("the file ends without \"endsolid\"");
    return std::move(soup_);
  }

 private:
  // Reads what the keyword begins. Returns false if the rest of the line is a name or a normal.
  bool take(std::string_view w) {
    std::string key = lowercase(w);
    if (key == "end") key += lowercase(words_.word());  // "end solid"
    if (key == "solid" || key == "endsolid") {
      ended_ = key == "endsolid" && !open_;
      return false;
    }
    if (key == "facet" || key == "endfacet") {
      facet(key == "facet");
    } else if (key == "normal") {
      for (int k = 0; k < 3; ++k) words_.word();
    } else if (key == "vertex") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = coordinate(words_.word(), words_.line());
      polygon_.push_back(corner_(p));
    } else if (key == "color") {
      return false;
    } else if (key != "outer" && key != "loop" && key != "endloop") {
      damaged(fmt::format("line {}: unknown keyword \"{}\"", words_.line(), printable(w)));
    }
    return true;
  }

  void facet(bool opens) {
    if (open_ == opens) damaged(fmt::format("line {}: a facet is not closed", words_.line()));
    open_ = opens;
    if (!open_) {
      require_corners(soup_.polygons.size(), polygon_.size());
      soup_.polygons.push_back(std::move(polygon_));
    }
    polygon_.clear();
  }

  Words words_;
  PolygonSoup soup_;
  Corners corner_{soup_};
  std::vector<int> polygon_;
  bool open_ = false, ended_ = false;
};

// Binary files may also begin with "solid", but only they contain bytes of zero: in the count of triangles,
// up to 16 million, and in the two bytes behind each triangle.
bool is_text(std::string_view bytes) {
  const auto first = bytes.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && lowercase(bytes.substr(first, 5)) == "solid" &&
         bytes.find('\0') == std::string_view::npos;
}

}  // namespace

PolygonSoup read_stl(std::string_view bytes, const Reading& reading) {
  if (!is_text(bytes)) return read_binary(bytes, reading);
  return AsciiReader(bytes).read();
}

}  // namespace terrazzo::load_mesh
