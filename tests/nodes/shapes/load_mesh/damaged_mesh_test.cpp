// Mesh files with false counts and sizes: always an error, within the memory and time that their size allows.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>

#include "nodes/export/formats/mesh_file.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
using namespace load_mesh;
namespace fs = std::filesystem;

class DamagedMesh : public ::testing::Test {
 protected:
  std::string code(const std::string& name, const std::string& bytes, const Reading& reading = {}) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return test::code_of([&] { read_mesh(folder / name, reading, TextureCoordinates::Read); });
  }
  fs::path folder = test::temporary_folder();
};

const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string kFaces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string ply(const std::string& vertices = kVertices, const std::string& faces = kFaces,
                const std::string& vertex_count = "4", const std::string& face_count = "4") {
  return "ply\nformat ascii 1.0\nelement vertex " + vertex_count +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + face_count +
         "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + faces;
}

template <class T>
std::string raw(T v, bool swapped = false) {
  std::string b(sizeof v, '\0');
  std::memcpy(b.data(), &v, sizeof v);
  if (swapped) std::reverse(b.begin(), b.end());
  return b;
}

std::string binary_ply(bool big, std::uint8_t corners = 3) {
  std::string out =
      "ply\nformat binary_" + std::string(big ? "big" : "little") +
      "_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty float z\n"
      "property uchar red\nelement face 1\nproperty list uchar ushort vertex_index\nend_header\n";
  for (const int v : {0, 1, 2})
    out += raw(v == 1 ? 1.5 : 0.0, big) + raw(v == 2 ? 1.0f : 0.0f, big) + raw(0.0f, big) + '\x07';
  out += static_cast<char>(corners);
  for (const std::uint16_t v : {0, 1, 2}) out += raw(v, big);
  return out;
}

std::string binary_stl(std::uint32_t promised, int triangles = 2) {
  std::string out = std::string(80, ' ') + raw(promised);
  for (int t = 0; t < triangles; ++t) {
    for (const float v : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, float(t)}) out += raw(v);
    out += std::string(2, '\0');
  }
  return out;
}

TEST_F(DamagedMesh, WordsInThePlaceOfNumbersInPly) {
  ASSERT_EQ(code("good.ply", ply()), "");
  for (const std::string word : {"nan", "-nan", "inf", "x", "1e99", "0x10", "--1", "1,5"})
    EXPECT_EQ(code("v.ply", ply("0 0 0\n1 0 0\n0 " + word + " 0\n0 0 1\n")), "unreadable-mesh") << word;
  for (const std::string word :
       {"nan", "-1", "-2147483648", "4294967295", "18446744073709551616", "1e9", "3.5", "inf"})
    EXPECT_NE(code("f.ply", ply(kVertices, "3 0 2 1\n" + word + " 0 1 3\n3 0 3 2\n3 1 2 3\n")), "") << word;
  for (const std::string word : {"nan", "-1", "4", "4294967295", "99999999999999999999"})
    EXPECT_NE(code("i.ply", ply(kVertices, "3 0 2 1\n3 0 1 " + word + "\n3 0 3 2\n3 1 2 3\n")), "") << word;
  for (const std::string number : {"4294967295", "-1", "nan", "99999999999999999999", "5"}) {
    EXPECT_NE(code("vc.ply", ply(kVertices, kFaces, number)), "") << number;
    EXPECT_NE(code("fc.ply", ply(kVertices, kFaces, "4", number)), "") << number;
  }
}

TEST_F(DamagedMesh, BinaryPlyOfBothByteOrders) {
  for (const bool big : {false, true}) {
    std::ofstream(folder / "b.ply", std::ios::binary) << binary_ply(big);
    const auto soup = read_mesh(folder / "b.ply");
    ASSERT_EQ(soup.vertices.size(), 3u);
    EXPECT_EQ(soup.vertices[1], Vec3(1.5, 0, 0));
    EXPECT_EQ(soup.vertices[2], Vec3(0, 1, 0));
    EXPECT_EQ(soup.polygons, (std::vector<std::vector<int>>{{0, 1, 2}}));
    EXPECT_EQ(code("more.ply", binary_ply(big, 255)), "unreadable-mesh");
    EXPECT_EQ(code("less.ply", binary_ply(big, 2)), "bad-mesh");
  }
}

TEST_F(DamagedMesh, StlThatPromisesMoreThanItHolds) {
  ASSERT_EQ(code("good.stl", binary_stl(2)), "");
  EXPECT_EQ(code("more.stl", binary_stl(3)), "unreadable-mesh");
  EXPECT_EQ(code("most.stl", binary_stl(4294967295u)), "unreadable-mesh");
  EXPECT_EQ(code("none.stl", binary_stl(0)), "unreadable-mesh");
  EXPECT_EQ(code("open.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"),
            "unreadable-mesh");
}

TEST_F(DamagedMesh, ObjThatNamesWhatIsNotThere) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  ASSERT_EQ(code("good.obj", v + "f 1/2/3 2//3 \\\n3\n"), "");
  for (const std::string face :
       {"f 1 2 4", "f 1 2 0", "f 1 2 -4", "f 1 2 nan", "f 1 2 99999999999999999999", "f 1 2"})
    EXPECT_NE(code("bad.obj", v + face + "\n"), "") << face;
  EXPECT_EQ(code("nan.obj", "v nan 0 0\n" + v + "f 2 3 4\n"), "unreadable-mesh");
}

// Exported files and text formats, truncated anywhere. An OBJ file does not contain its number of lines:
// truncated between two lines it is another valid file whose surface is open, which LoadMesh rejects.
TEST_F(DamagedMesh, ACutFileIsAnError) {
  Shapes shapes;
  shapes.shapes.emplace_back();
  Mesh& m = shapes.shapes[0].mesh;
  m.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  m.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::map<std::string, std::string> files = {{"t.ply", ply()},
                                              {"t.off", "OFF\n4 4 0\n" + kVertices + kFaces}};
  for (const char* name : {"b.ply", "b.stl"}) {
    write_mesh(folder / name, shapes);
    files[name] = *read_file(folder / name);
  }
  files["t.stl"] = "solid s\n";
  for (const auto& t : m.triangles) {
    files["t.stl"] += "facet normal 0 0 1\nouter loop\n";
    for (const int v : t)
      files["t.stl"] +=
          fmt::format("vertex {} {} {}\n", m.vertices[v].x(), m.vertices[v].y(), m.vertices[v].z());
    files["t.stl"] += "endloop\nendfacet\n";
  }
  files["t.stl"] += "endsolid s\n";
  for (const auto& [name, whole] : files) {
    ASSERT_EQ(code(name, whole), "") << name;
    // The last characters of a text may be a line end and a name.
    const std::size_t last = name[0] == 'b' ? whole.size() - 1 : whole.size() - 4;
    for (std::size_t size = 0; size <= last; ++size)
      ASSERT_NE(code("cut" + name, whole.substr(0, size)), "")
          << name << " cut to " << size << " of " << whole.size();
  }
  write_mesh(folder / "b.obj", shapes);
  const std::string obj = *read_file(folder / "b.obj");
  const auto at = obj.rfind("f ");
  EXPECT_EQ(test::code_of([&] {
              std::ofstream(folder / "cut.obj") << obj.substr(0, at);
              test::run_node("LoadMesh", {}, {{"path", (folder / "cut.obj").string()}});
            }),
            "open-mesh");
}

// A reader needs at most a multiple of the file's size, and checks the budget before it allocates.
TEST_F(DamagedMesh, TheBudgetIsKept) {
  Reading little;
  little.memory = 1000;
  EXPECT_EQ(code("good.ply", ply(), little), "too-large");
  little.memory = 100000;
  EXPECT_EQ(code("good.ply", ply(), little), "");
}

// Messages quote only a short part of the file, and no terminal control characters.
TEST_F(DamagedMesh, MessagesStayShort) {
  std::ofstream(folder / "long.ply", std::ios::binary)
      << ply("0 0 \x1b[31m" + std::string(100000, 'x') + "\n");
  try {
    read_mesh(folder / "long.ply");
    FAIL();
  } catch (const Error& e) {
    EXPECT_LT(e.diagnostic().message.size(), 400u);
    EXPECT_EQ(e.diagnostic().message.find('\x1b'), std::string::npos);
  }
}

TEST_F(DamagedMesh, MutationsOfEveryFormatEndInAMeshOrAnError) {
  const std::string off = "OFF\n4 4 0\n" + kVertices + kFaces;
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string ascii_stl =
      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid\n";
  const std::pair<const char*, std::string> seeds[] = {{"m.ply", ply()},         {"m.ply", binary_ply(false)},
                                                       {"m.off", off},           {"m.obj", obj},
                                                       {"m.stl", binary_stl(2)}, {"m.stl", ascii_stl}};
  const char* const words[] = {"nan", "-1", "4294967295", " ", "\n", "1e308"};
  int kept = 0;
  for (std::uint64_t k = 0; k < 1200; ++k) {
    Random r(5, 5, k);
    const auto& [name, seed] = seeds[k % 6];
    std::string bytes = seed;
    for (std::uint64_t edits = 0; edits <= k % 3; ++edits) {
      const std::size_t at = r.below(bytes.size());
      switch (r.below(4)) {
        case 0:
          bytes[at] = static_cast<char>(r.below(256));
          break;
        case 1:
          bytes.replace(at, 1, words[r.below(6)]);
          break;
        case 2:
          bytes.resize(at + 1);
          break;
        default:
          bytes.insert(at, bytes.substr(r.below(bytes.size()), 40));
      }
    }
    kept += code(name, bytes).empty();
  }
  EXPECT_GT(kept, 50);
}

}  // namespace
}  // namespace terrazzo
