#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>

#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

enum class Type { I8, U8, I16, U16, I32, U32, I64, U64, F32, F64 };

std::optional<Type> type_named(std::string_view name) {
  // The 64-bit integers are not in the format's description; meshio writes them.
  static const std::map<std::string_view, Type> types = {
      {"char", Type::I8},   {"uchar", Type::U8},   {"short", Type::I16},   {"ushort", Type::U16},
      {"int", Type::I32},   {"uint", Type::U32},   {"float", Type::F32},   {"double", Type::F64},
      {"int8", Type::I8},   {"uint8", Type::U8},   {"int16", Type::I16},   {"uint16", Type::U16},
      {"int32", Type::I32}, {"uint32", Type::U32}, {"float32", Type::F32}, {"float64", Type::F64},
      {"int64", Type::I64}, {"uint64", Type::U64}};
  const auto it = types.find(name);
  if (it == types.end()) return {};
  return it->second;
}

struct Property {
  std::string name;
  Type type;                   // of the value, or of the items of a list
  std::optional<Type> length;  // type of the length, for lists only
};
struct Element {
  std::string name;
  std::uint64_t count;
  std::vector<Property> properties;
};
enum class Format { Ascii, Little, Big };
struct Header {
  Format format = Format::Ascii;
  std::vector<Element> elements;
};

Header read_header(Words& words, std::size_t size) {
  Header header;
  bool format = false;
  if (!words.next_line() || words.word() != "ply") damaged("does not begin as a PLY file");
  while (words.next_line()) {
    const std::string_view key = words.word();
    const auto not_understood = [&] {
      damaged(fmt::format("line {} of the header is invalid", words.line()));
    };
    if (key == "end_header") {
      if (!format) damaged("the header contains no format");
      return header;
    }
    if (key == "format") {
      const std::string_view kind = words.word();
      if (kind == "ascii")
        header.format = Format::Ascii;
      else if (kind == "binary_little_endian")
        header.format = Format::Little;
      else if (kind == "binary_big_endian")
        header.format = Format::Big;
      else
        damaged("the format \"" + printable(kind) + "\" is unknown");
      if (words.word() != "1.0") damaged("the version of the format is unknown");
      format = true;
    } else if (key == "element") {
      const std::string name(words.word());
      header.elements.push_back(
          {name, count(words.word(), size, words.line(), "the number of elements"), {}});
    } else if (key == "property") {
      if (header.elements.empty()) not_understood();
      Property p;
      std::string_view type = words.word();
      if (type == "list") {
        p.length = type_named(words.word());
        if (!p.length) not_understood();
        type = words.word();
      }
      const auto known = type_named(type);
      p.name = words.word();
      if (!known || p.name.empty()) not_understood();
      p.type = *known;
      header.elements.back().properties.push_back(p);
    } else if (key != "comment" && key != "obj_info" && !key.empty()) {
      not_understood();
    }
  }
  damaged("the header has no end");
}

// The numbers of the body, in file order.
class Numbers {
 public:
  Numbers(Format format, Words& words) : format_(format), words_(words), bytes_(words.rest()) {}

  double next(Type type) {
    if (format_ == Format::Ascii) return of_word(words_.word_anywhere(), type);
    switch (type) {
      case Type::I8:
        return take<std::int8_t>();
      case Type::U8:
        return take<std::uint8_t>();
      case Type::I16:
        return take<std::int16_t>();
      case Type::U16:
        return take<std::uint16_t>();
      case Type::I32:
        return take<std::int32_t>();
      case Type::U32:
        return take<std::uint32_t>();
      case Type::I64:
        return take<std::int64_t>();
      case Type::U64:
        return take<std::uint64_t>();
      case Type::F32:
        return take<float>();
      case Type::F64:
        return take<double>();
    }
    return 0;
  }

  // The number of values of a list, 1 for other properties.
  std::uint64_t values(const Property& p) {
    if (!p.length) return 1;
    const double n = next(*p.length);
    if (!(n >= 0 && n < 0x1p53 && n == std::floor(n)))
      damaged(fmt::format("the list '{}' has the length {}", printable(p.name), n));
    return static_cast<std::uint64_t>(n);
  }

  // Skips a property that has no meaning here; in a text it may be anything, such as "nan".
  void skip(const Property& p) {
    for (std::uint64_t left = values(p); left > 0; --left) {
      if (format_ == Format::Ascii)
        words_.word_anywhere();
      else
        next(p.type);
    }
  }

 private:
  double of_word(std::string_view word, Type type) const {
    if (type == Type::F32 || type == Type::F64) return coordinate(word, words_.line());
    const bool negative = word.starts_with('-');
    const auto n = count(word.substr(negative ? 1 : 0), 4294967295u, words_.line(), "a whole number");
    return negative ? -static_cast<double>(n) : static_cast<double>(n);
  }
  template <class T>
  T take() {
    if (bytes_.size() < sizeof(T)) damaged("the file ends before all elements that its header lists");
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data(), sizeof(T));
    if ((format_ == Format::Big) == (std::endian::native == std::endian::little))
      std::reverse(raw, raw + sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    T v;
    std::memcpy(&v, raw, sizeof(T));
    return v;
  }
  Format format_;
  Words& words_;
  std::string_view bytes_;
};

void read_vertices(const Element& element, Numbers& numbers, PolygonSoup& soup) {
  std::vector<int> axis;  // for each property, or -1
  bool has[3] = {};
  for (const auto& p : element.properties) {
    axis.push_back(p.length || p.name.size() != 1 || p.name[0] < 'x' || p.name[0] > 'z' ? -1
                                                                                        : p.name[0] - 'x');
    if (axis.back() >= 0) has[axis.back()] = true;
  }
  if (element.count > 0 && !(has[0] && has[1] && has[2])) damaged("the vertices lack x, y or z");
  for (std::uint64_t i = 0; i < element.count; ++i) {
    Vec3 point = Vec3::Zero();
    for (std::size_t k = 0; k < element.properties.size(); ++k)
      if (axis[k] < 0)
        numbers.skip(element.properties[k]);
      else
        point[axis[k]] = numbers.next(element.properties[k].type);
    soup.vertices.push_back(point);
  }
}

// The vertices of element `i` in its property vertex_indices, not below `least`.
std::vector<int> read_indices(const Element& element, std::uint64_t i, int least, Numbers& numbers) {
  std::vector<int> out;
  bool found = false;
  for (const Property& p : element.properties) {
    if (found || !p.length || (p.name != "vertex_indices" && p.name != "vertex_index")) {
      numbers.skip(p);
      continue;
    }
    found = true;
    for (std::uint64_t left = numbers.values(p); left > 0; --left) {
      const double v = numbers.next(p.type);
      if (!(v >= least && v <= std::numeric_limits<int>::max() && v == std::floor(v)))
        throw Error("bad-mesh", fmt::format("{} {} refers to vertex {}", element.name, i, v),
                    "the file is damaged: export it again");
      out.push_back(v);
    }
  }
  if (!found) damaged(fmt::format("the element '{}' lacks the list vertex_indices", element.name));
  return out;
}

void read_faces(const Element& element, Numbers& numbers, PolygonSoup& soup) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    auto polygon = read_indices(element, i, 0, numbers);
    require_corners(i, polygon.size());
    soup.polygons.push_back(std::move(polygon));
  }
}

// Each vertex of a strip after the second makes a triangle with the two before it; every other triangle is
// turned. −1 begins a new strip.
void read_strips(const Element& element, Numbers& numbers, PolygonSoup& soup) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    const auto strip = read_indices(element, i, -1, numbers);
    std::size_t start = 0;
    for (std::size_t k = 0; k < strip.size(); ++k) {
      if (strip[k] < 0) {
        start = k + 1;
        continue;
      }
      if (k < start + 2) continue;
      int a = strip[k - 2], b = strip[k - 1];
      const int c = strip[k];
      // Strips repeat vertices in order to turn; such triangles have no area.
      if (a == b || b == c || c == a) continue;
      if ((k - start) % 2 == 1) std::swap(a, b);
      soup.polygons.push_back({a, b, c});
    }
  }
}

}  // namespace

PolygonSoup read_ply(std::string_view bytes) {
  Words words(bytes);
  const Header header = read_header(words, bytes.size());
  Numbers numbers(header.format, words);
  PolygonSoup soup;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      read_vertices(element, numbers, soup);
    } else if (element.name == "face") {
      read_faces(element, numbers, soup);
    } else if (element.name == "tristrips") {
      read_strips(element, numbers, soup);
    } else if (!element.properties.empty()) {
      for (std::uint64_t i = 0; i < element.count; ++i)
        for (const Property& p : element.properties) numbers.skip(p);
    }
  }
  return soup;
}

}  // namespace terrazzo::load_mesh
