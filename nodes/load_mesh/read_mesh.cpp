#include "nodes/load_mesh/read_mesh.h"

#include <fmt/format.h>

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <OpenMesh/Core/IO/reader/OFFReader.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <mutex>
#include <set>
#include <sstream>

#include "graph/diagnostic.h"

namespace terrazzo {

namespace {

namespace om = OpenMesh;

// OpenMesh's own importer builds half-edges at once, and so cuts faces loose that meet an edge twice. This
// one keeps the file's faces as they are: whether they bound a solid is judged afterwards, with all of them
// present.
class SoupImporter final : public om::IO::BaseImporter {
 public:
  explicit SoupImporter(PolygonSoup& soup) : soup_(soup) {}

  om::VertexHandle add_vertex(const om::Vec3f& p) override { return add({p[0], p[1], p[2]}); }
  om::VertexHandle add_vertex(const om::Vec3d& p) override { return add({p[0], p[1], p[2]}); }
  om::VertexHandle add_vertex() override { return add(Vec3::Zero()); }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    if (v.is_valid() && v.idx() < static_cast<int>(soup_.vertices.size()))
      soup_.vertices[v.idx()] = {p[0], p[1], p[2]};
  }
  om::FaceHandle add_face(const VHandles& corners) override {
    std::vector<int> polygon;
    for (const auto v : corners) polygon.push_back(v.idx());
    soup_.polygons.push_back(std::move(polygon));
    return om::FaceHandle(static_cast<int>(soup_.polygons.size()) - 1);
  }
  size_t n_vertices() const override { return soup_.vertices.size(); }
  size_t n_faces() const override { return soup_.polygons.size(); }
  size_t n_edges() const override { return 0; }

  // Half-edge input and attributes: of no use here.
  om::HalfedgeHandle add_edge(om::VertexHandle, om::VertexHandle) override { return om::HalfedgeHandle(); }
  om::FaceHandle add_face(om::HalfedgeHandle) override { return om::FaceHandle(); }
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_normal(om::VertexHandle, const om::Vec3f&) override {}
  void set_normal(om::VertexHandle, const om::Vec3d&) override {}
  void set_color(om::VertexHandle, const om::Vec3uc&) override {}
  void set_color(om::VertexHandle, const om::Vec4uc&) override {}
  void set_color(om::VertexHandle, const om::Vec3f&) override {}
  void set_color(om::VertexHandle, const om::Vec4f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec2f&) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_next(om::HalfedgeHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec3f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}

 private:
  om::VertexHandle add(const Vec3& p) {
    soup_.vertices.push_back(p);
    return om::VertexHandle(static_cast<int>(soup_.vertices.size()) - 1);
  }
  PolygonSoup& soup_;
};

// OpenMesh's readers and their message streams are one for the whole process.
std::mutex& reader_mutex() {
  static std::mutex m;
  return m;
}

// OpenMesh's PLY reader never returns from a header that breaks off or holds words that it does not know, so
// that headers are checked before. Returns what is wrong, or "".
std::string ply_header_fault(std::istream& in, std::uintmax_t file_size) {
  static const std::set<std::string> types{"char",  "uchar",  "short",   "ushort", "int",   "uint",
                                           "float", "double", "int8",    "uint8",  "int16", "uint16",
                                           "int32", "uint32", "float32", "float64"};
  std::string line, word;
  bool element = false, format = false;
  for (int number = 1; std::getline(in, line) && number < 10000; ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    words >> word;
    if (number == 1) {
      if (word != "ply") return "does not begin as a PLY file";
    } else if (word == "end_header") {
      return !format ? "its header names no format" : !element ? "its header names no elements" : "";
    } else if (word == "format") {
      std::string kind;
      std::string version;
      words >> kind >> version;
      if (version != "1.0") return "its format is of an unknown version";
      if (kind != "ascii" && kind != "binary_little_endian" && kind != "binary_big_endian")
        return "its format \"" + kind + "\" is unknown";
      format = true;
    } else if (word == "element") {
      std::string name;
      std::uintmax_t count = 0;
      if (!(words >> name >> count)) return fmt::format("line {} of its header is not understood", number);
      if (count > file_size)
        return fmt::format("its header promises {} of {}, more than the file can hold", count, name);
      element = true;
    } else if (word == "property") {
      std::string type, name, of, length;
      bool good = element && static_cast<bool>(words >> type);
      if (good && type == "list") good = words >> length >> of && types.count(length) && types.count(of);
      if (good && type != "list") good = types.count(type) > 0;
      if (!good || !(words >> name)) return fmt::format("line {} of its header is not understood", number);
    } else if (word != "comment" && word != "obj_info") {
      return fmt::format("line {} of its header is not understood", number);
    }
    word.clear();
  }
  return "its header does not end";
}

bool is_count(const std::string& word, std::uintmax_t most) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string::npos && word.size() < 16 &&
         std::stoull(word) <= most;
}

// As a stream reads floats: neither nan nor hexadecimal, and not beyond their range.
bool is_number(const std::string& word) {
  char* end = nullptr;
  const double v = std::strtod(word.c_str(), &end);
  return end == word.c_str() + word.size() &&
         word.find_first_not_of("0123456789+-.eE") == std::string::npos &&
         std::abs(v) <= std::numeric_limits<float>::max();
}

// What OpenMesh, which expects a vertex and a face a line, would take for a number of corners though it
// cannot be: it reads -1 as four thousand million, and what slipped out of place as whatever stands there.
std::string off_body_fault(std::istream& in, const std::string& kind, std::uintmax_t vertices,
                           std::uintmax_t faces, std::uintmax_t file_size) {
  const std::size_t least =
      3 + (kind.find('N') != std::string::npos ? 3 : 0) + (kind.find("ST") != std::string::npos ? 2 : 0);
  const std::uintmax_t most = std::max<std::uintmax_t>(file_size, 255);  // of a colour
  std::string line, word;
  for (std::uintmax_t read = 0; read < vertices + faces && std::getline(in, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::size_t numbers = 0;
    for (; words >> word; ++numbers) {
      if (!is_number(word)) return fmt::format("\"{}\" is not a number", word);
      if (read >= vertices && word[0] != '.' && !is_count(word.substr(0, word.find('.')), most))
        return fmt::format("face {} has \"{}\" for a number of corners, a vertex or a colour",
                           read - vertices, word);
    }
    if (numbers == 0) continue;
    if (read < vertices && numbers < least)
      return fmt::format("vertex {} has {} numbers of {}", read, numbers, least);
    ++read;
  }
  return {};
}

// Likewise OFF counts that no file of this size can meet: the reader would loop for as long as they say.
std::string off_header_fault(std::istream& in, std::uintmax_t file_size) {
  std::string line, all;
  for (int number = 0; number < 100 && std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    all += line + ' ';
    std::istringstream words(all);
    std::string word;
    if (!(words >> word)) continue;
    if (word.find("OFF") == std::string::npos) return "does not begin as an OFF file";
    std::string counts[2];
    if (!(words >> counts[0])) continue;
    if (counts[0] == "BINARY") return {};
    std::string edges;
    if (!(words >> counts[1] >> edges)) continue;
    for (const auto& c : counts)
      if (!is_count(c, file_size)) return "its counts \"" + counts[0] + ' ' + counts[1] + "\" cannot be";
    return off_body_fault(in, word, std::stoull(counts[0]), std::stoull(counts[1]), file_size);
  }
  return "its header does not end";
}

bool run_reader(const std::string& path, const std::string& extension, PolygonSoup& soup,
                std::string& words) {
  const std::lock_guard lock(reader_mutex());
  // Naming the readers makes the linker keep them where OpenMesh is a static library.
  om::IO::BaseReader* reader = extension == ".obj"   ? static_cast<om::IO::BaseReader*>(&om::IO::OBJReader())
                               : extension == ".ply" ? static_cast<om::IO::BaseReader*>(&om::IO::PLYReader())
                               : extension == ".stl" ? static_cast<om::IO::BaseReader*>(&om::IO::STLReader())
                                                     : static_cast<om::IO::BaseReader*>(&om::IO::OFFReader());
  std::ostringstream heard;
  struct Redirect {
    std::ostream& stream;
    std::streambuf* before;
    Redirect(std::ostream& s, std::ostringstream& to) : stream(s), before(s.rdbuf(to.rdbuf())) {}
    ~Redirect() { stream.rdbuf(before); }
  } errors(::omerr(), heard), notes(::omlog(), heard);
  SoupImporter importer(soup);
  om::IO::Options options;
  bool good = false;
  try {
    good = reader->can_u_read(path) && reader->read(path, importer, options);
  } catch (const std::exception& e) {
    heard << e.what();
  }
  words = heard.str();
  std::replace(words.begin(), words.end(), '\n', ' ');
  while (!words.empty() && words.back() == ' ') words.pop_back();
  return good;
}

}  // namespace

PolygonSoup read_mesh(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  if (extension != ".obj" && extension != ".ply" && extension != ".stl" && extension != ".off")
    throw Error("unknown-format",
                fmt::format("{}: no mesh format is known by the extension \"{}\"", name, extension),
                "give an .obj, .ply, .stl or .off file");
  if (!std::ifstream(path).good())
    throw Error("unreadable-mesh", name + ": cannot be opened", "check the file's permissions");
  if (extension == ".ply" || extension == ".off") {
    std::ifstream in(path, std::ios::binary);
    const auto size = std::filesystem::file_size(path);
    if (const auto fault = extension == ".ply" ? ply_header_fault(in, size) : off_header_fault(in, size);
        !fault.empty())
      throw Error("unreadable-mesh", name + ": " + fault, "the file is damaged: write it again");
  }
  PolygonSoup soup;
  std::string words;
  const bool good = run_reader(path.string(), extension, soup, words);
  if (!good || soup.polygons.empty())
    throw Error("unreadable-mesh",
                name + ": " +
                    (!words.empty() ? words
                     : good         ? "holds no faces"
                                    : "is not a " + extension.substr(1) + " file"),
                "check that the file is whole and in the format that its extension says");
  const int n = static_cast<int>(soup.vertices.size());
  for (std::size_t f = 0; f < soup.polygons.size(); ++f) {
    if (soup.polygons[f].size() < 3)
      throw Error("bad-mesh", fmt::format("{}: face {} has {} corners", name, f, soup.polygons[f].size()),
                  "remove lines and points from the mesh");
    for (const int v : soup.polygons[f])
      if (v < 0 || v >= n)
        throw Error("bad-mesh", fmt::format("{}: face {} names vertex {} of {}", name, f, v, n),
                    "the file is damaged: write it again");
  }
  for (int v = 0; v < n; ++v)
    if (!soup.vertices[v].allFinite())
      throw Error("bad-mesh", fmt::format("{}: vertex {} is not a finite number", name, v),
                  "the file is damaged: write it again");
  return soup;
}

}  // namespace terrazzo
