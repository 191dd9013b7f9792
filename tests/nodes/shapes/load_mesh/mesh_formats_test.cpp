// What different programs write in the same formats.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "nodes/data/shapes.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_mesh;
namespace fs = std::filesystem;

std::string substituted(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

const char* const kTetrahedronFacets =
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n";
const std::string kTetrahedronObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

template <class T>
std::string packed(T v, bool swapped = false) {
  std::string b(sizeof v, '\0');
  std::memcpy(b.data(), &v, sizeof v);
  if (swapped) std::reverse(b.begin(), b.end());
  return b;
}

class MeshFormats : public ::testing::Test {
 protected:
  // The volume of the only body in six parts, which is 1 for the tetrahedron.
  double six(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    run = test::run_node("LoadMesh", {}, {{"path", (folder / name).string()}});
    const auto& shapes = run.output<Shapes>("shapes").shapes;
    return shapes.size() == 1 ? 6 * shapes[0].volume : -static_cast<double>(shapes.size());
  }
  std::string code(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return test::code_of([&] { read_mesh(folder / name); });
  }
  const fs::path folder = test::temporary_folder();
  test::NodeRun run;
};

TEST_F(MeshFormats, SpellingsOfAsciiStl) {
  const std::string plain = std::string("solid s\n") + kTetrahedronFacets + "endsolid s\n";
  std::string capitals = plain;
  for (char& c : capitals) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  const std::string files[] = {
      plain,
      capitals,
      substituted(plain, "endsolid", "end solid"),
      substituted(substituted(plain, "endloop", "end loop"), "endfacet", "END FACET"),
      substituted(plain, "solid s", "solid a name of facets with spaces"),
      substituted(plain, "solid s", "Solid\tUnity Mesh"),
      substituted(plain, " s\n", "\n"),
      substituted(plain, "normal 0 0 0", "normal nan -nan(ind) 1.#IND"),
      substituted(plain, "facet normal 0 0 0", "facet"),
      substituted(plain, "\n", "\r\n"),
      substituted(plain, "\n", "\r"),
      "\n\n  " + plain + "\n\n",
      "\xef\xbb\xbf" + plain,
      substituted(plain, "\nvertex", " vertex"),
      substituted(plain, "vertex 1 0 0", "vertex 1.000000e+00 -0.0 +0"),
  };
  for (const std::string& file : files) EXPECT_NEAR(six("a.stl", file), 1, 1e-12) << file.substr(0, 60);
  EXPECT_EQ(
      six("two.stl", plain + substituted(substituted(plain, "vertex 0", "vertex 5"), "vertex 1", "vertex 6")),
      -2);
  EXPECT_EQ(code("cut.stl", plain.substr(0, plain.find("endsolid"))), "unreadable-mesh");
  EXPECT_EQ(code("word.stl", substituted(plain, "outer", "outré")), "unreadable-mesh");
}

std::string stl_bytes(const std::string& header, const std::string& behind, std::uint32_t count = 4) {
  std::string out = header + std::string(80 - header.size(), ' ') + packed(count);
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const auto& t : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    out += packed(0.f) + packed(0.f) + packed(0.f);
    for (const int v : t)
      for (const float x : corners[v]) out += packed(x);
    out += std::string(2, '\0');
  }
  return out + behind;
}

TEST_F(MeshFormats, BinaryStlThatLooksLikeTextAndBytesBehindIt) {
  EXPECT_NEAR(six("a.stl", stl_bytes("solid made by a CAD program", "")), 1, 1e-6);
  EXPECT_TRUE(run.warnings.empty());
  for (const std::string& behind : {std::string("\n"), std::string(130, 'x')}) {
    EXPECT_NEAR(six("b.stl", stl_bytes("solid facet normal vertex", behind)), 1, 1e-6);
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_EQ(run.warnings[0],
              fmt::format("b.stl: its header says 4 triangles; the {} bytes behind them are ignored",
                          behind.size()));
  }
  EXPECT_EQ(code("c.stl", stl_bytes("solid", "", 5)), "unreadable-mesh");
  EXPECT_EQ(code("d.stl", stl_bytes("solid", "", 0)), "unreadable-mesh");
}

// A tetrahedron as triangle strips: an even and an odd triangle, one that turns by repeating a vertex, and
// restarts.
const std::vector<int> kStripOfTetrahedron{0, 2, 1, 3, -1, 0, 3, 3, 2, 0, -1, -1};

std::string strip_file(bool binary, bool big, const std::string& index_type = "int") {
  std::string out = fmt::format(
      "ply\nformat {} 1.0\ncomment faces\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
      "float "
      "z\nproperty uchar flag\nelement tristrips 1\nproperty list int {} vertex_indices\nproperty uchar "
      "last\nend_header\n",
      binary ? (big ? "binary_big_endian" : "binary_little_endian") : "ascii", index_type);
  for (int v = 0; v < 4; ++v) {
    const float p[3] = {v == 1 ? 1.f : 0.f, v == 2 ? 1.f : 0.f, v == 3 ? 1.f : 0.f};
    if (binary)
      out += packed(p[0], big) + packed(p[1], big) + packed(p[2], big) + '\x05';
    else
      out += fmt::format("{} {} {} 5\n", p[0], p[1], p[2]);
  }
  out += binary ? packed(static_cast<std::int32_t>(kStripOfTetrahedron.size()), big)
                : fmt::format("{}", kStripOfTetrahedron.size());
  for (const int v : kStripOfTetrahedron)
    out += !binary                 ? fmt::format(" {}", v)
           : index_type == "short" ? packed(static_cast<std::int16_t>(v), big)
           : index_type == "float" ? packed(static_cast<float>(v), big)
           : index_type == "int64" ? packed(static_cast<std::int64_t>(v), big)
                                   : packed(static_cast<std::int32_t>(v), big);
  return out + (binary ? "\x01" : " 1\n");
}

TEST_F(MeshFormats, TriangleStripsOfPly) {
  const auto expected = std::vector<std::vector<int>>{{0, 2, 1}, {1, 2, 3}, {3, 2, 0}};
  for (const char* type : {"int", "short", "float", "int64"})
    for (const bool big : {false, true}) {
      std::ofstream(folder / "s.ply", std::ios::binary) << strip_file(true, big, type);
      EXPECT_EQ(read_mesh(folder / "s.ply").polygons, expected) << type << big;
    }
  std::ofstream(folder / "t.ply") << strip_file(false, false);
  EXPECT_EQ(read_mesh(folder / "t.ply").polygons, expected);
  EXPECT_EQ(code("u.ply", substituted(strip_file(false, false), "12 0 2", "12 0 -2")), "bad-mesh");
  EXPECT_EQ(code("v.ply", substituted(strip_file(false, false), "12 0 2", "12 0 4")), "bad-mesh");
}

TEST_F(MeshFormats, PlyWithOtherListsElementsAndLineEnds) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment by hand\nobj_info none\nelement camera 1\nproperty list float double "
      "view\nproperty float focus\nelement vertex 4\nproperty double y\nproperty double x\nproperty list "
      "uchar "
      "uchar tags\nproperty float quality\nproperty double z\nelement edge 1\nproperty int vertex1\nproperty "
      "int "
      "vertex2\nelement face 4\nproperty uchar red\nproperty list uint uint64 vertex_index\nproperty list "
      "uchar "
      "float texcoord\nelement material 0\nend_header\n"
      "2 0.5 nan 1\n"
      "0 0 0 nan 0\n0 1 2 7 8 inf 0\n1 0 0 -nan 0\n0 0 1 9 1e99 1\n"
      "0 1\n"
      "7 3 0 2 1 0\n7 3 0 1 3 2 0.5 0.5\n7 3 0 3 2 0\n7 3 1 2 3 0\n";
  EXPECT_NEAR(six("a.ply", text), 1, 1e-12);
  EXPECT_NEAR(six("b.ply", substituted(text, "\n", "\r\n")), 1, 1e-12);
  EXPECT_NEAR(six("c.ply", substituted(text, "\n", "\r")), 1, 1e-12);
  for (const char* const length : {"-1", "2.5", "nan"})
    EXPECT_EQ(
        code("d.ply", substituted(text, "\n2 0.5 nan 1\n", std::string("\n") + length + " 0.5 nan 1\n")),
        "unreadable-mesh");
  // A header with \r\n or \r before binary data.
  const std::string binary = strip_file(true, false),
                    header = binary.substr(0, binary.find("end_header\n") + 11);
  for (const char* end : {"\r\n", "\r"}) {
    std::ofstream(folder / "e.ply", std::ios::binary)
        << substituted(header, "\n", end) + binary.substr(header.size());
    EXPECT_EQ(read_mesh(folder / "e.ply").polygons.size(), 3u);
  }
}

TEST_F(MeshFormats, ObjWithOtherLineEndsReferencesAndContinuations) {
  const std::string files[] = {
      substituted(kTetrahedronObj, "\n", "\r"),
      substituted(kTetrahedronObj, "\n", "\r\n"),
      "# a comment\r\n" + substituted(kTetrahedronObj, "f 2 3 4", "f 2 \\\r\n3 \\\r\n4"),
      substituted(kTetrahedronObj, "f 2 3 4", "f -3 -2 -1"),
      "mtllib a b.mtl\no a name\ng a b\ns off\nusemtl x\n" +
          substituted(kTetrahedronObj, "v 1 0 0", "v 1 0 0 0.5 0.5 0.5 # red"),
      substituted(kTetrahedronObj, "f ", "fo "),
      "\xef\xbb\xbf" + kTetrahedronObj,
  };
  for (const std::string& file : files) EXPECT_NEAR(six("a.obj", file), 1, 1e-12) << file.substr(0, 60);
}

TEST_F(MeshFormats, TextureCoordinatesOfObj) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto read = [&](const std::string& more, TextureCoordinates uv = TextureCoordinates::Read) {
    std::ofstream(folder / "t.obj", std::ios::binary) << vertices << more;
    return read_mesh(folder / "t.obj", {}, uv);
  };
  using Coordinates = std::vector<std::vector<Eigen::Vector2f>>;
  const Eigen::Vector2f a(0.25f, 1), b(0.5f, 1), c(1, 0.5f);
  // Without v, with a sign, with a third number, and too small for single precision.
  const std::string lines = "vt 0.25\nvt +0.5 1e-60 0\nvt 1 +.5\n";
  EXPECT_EQ(read(lines + "f 1/1 2/2 3/3\n").uv, (Coordinates{{a, b, c}}));
  EXPECT_EQ(read(lines + "f 1/-3 2/-2 3/-1\n").uv, (Coordinates{{a, b, c}}));
  // Damaged lines keep their numbers.
  EXPECT_EQ(read("vt\nvt x 1\n" + lines + "f 1/3 2/4 3/5\n").uv, (Coordinates{{a, b, c}}));
  for (const char* face :
       {"f 1 2 3\n", "f 1/1 2/2 3\n", "f 1/1 2/2 3/4\n", "f 1/1 2/2 3/5\n", "f 1/1 2/2 3/0\n"}) {
    const auto soup = read(lines + "vt nan 0\nf 1/1 2/2 3/3\n" + face);
    EXPECT_TRUE(soup.uv.empty()) << face;
    EXPECT_EQ(soup.without_uv, 1u) << face;
  }
  const auto warnings = [&] {
    return test::run_node("LoadMesh", {}, {{"path", (folder / "t.obj").string()}, {"surface", "true"}})
        .warnings;
  };
  ASSERT_EQ(warnings().size(), 1u);
  EXPECT_NE(warnings()[0].find("1 of 2 faces have no UV coordinates"), std::string::npos) << warnings()[0];
  read("f 1 2 3\n");
  EXPECT_TRUE(warnings().empty());
  const auto ignored = read(lines + "f 1/1 2/2 3/3\n", TextureCoordinates::Ignored);
  EXPECT_TRUE(ignored.uv.empty());
  EXPECT_EQ(ignored.without_uv, 0u);
}

TEST_F(MeshFormats, VariantsOfOff) {
  const std::string faces = "3 0 2 1\n3 0 1 3 255 0 0\n3 0 3 2 0.5 0.5 0.5 1\n3 1 2 3\n";
  const auto off = [&](const std::string& header, const std::string& more) {
    std::string out = header + "\n";
    for (const char* v : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"}) out += v + more + "\n";
    return out + faces;
  };
  const std::string files[] = {
      off("OFF\n4 4 6", ""),
      off("OFF 4 4 6", ""),
      off("4 4 6", ""),
      off("off\n4 4", ""),
      off("COFF\n4 4 0", " 1 0 0 1"),
      off("NOFF\n# normals\n\n4 4 0", " 0 0 1"),
      off("CNOFF\n4 4 0", " 0 0 1 255 0 0 255"),
      off("STOFF\n4 4 0", " 0.5 0.5"),
      substituted(off("OFF\n4 4 6", ""), "\n", "\r"),
      substituted(off("OFF # a\n# b\n4 4 6", ""), "\n", "\r\n"),
  };
  for (const std::string& file : files) EXPECT_NEAR(six("a.off", file), 1, 1e-12) << file.substr(0, 30);
  for (const char* header : {"4OFF\n4 4 0", "nOFF\n3\n4 4 0", "OFFX\n4 4 0", "OFF BINARY\n4 4 0"})
    EXPECT_EQ(code("b.off", off(header, " 1")), "unreadable-mesh") << header;
}

}  // namespace
}  // namespace terrazzo
