// Files with several bodies, with cavities, and far from the origin.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/shapes/load_mesh/bodies.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_mesh;
namespace fs = std::filesystem;

// Triangles of boxes, as STL files hold them.
struct BoxSoup {
  std::vector<std::array<Vec3, 3>> triangles;

  BoxSoup& box(const Vec3& low, const Vec3& high, bool inward = false) {
    const auto corner = [&](int i) {
      return Vec3(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
    };
    for (const auto& [a, b, c, d] :
         {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
      add(corner(a), corner(b), corner(c), inward);
      add(corner(a), corner(c), corner(d), inward);
    }
    return *this;
  }
  void add(const Vec3& a, const Vec3& b, const Vec3& c, bool inward) {
    triangles.push_back(inward ? std::array{a, c, b} : std::array{a, b, c});
  }
};

class MeshBodies : public ::testing::Test {
 protected:
  fs::path stl(const BoxSoup& soup, const std::string& name = "a.stl") {
    std::ofstream out(folder / name);
    out << "solid s\n";
    for (const auto& t : soup.triangles) {
      out << "facet normal 0 0 0\nouter loop\n";
      for (const Vec3& v : t) out << fmt::format("vertex {} {} {}\n", v.x(), v.y(), v.z());
      out << "endloop\nendfacet\n";
    }
    out << "endsolid s\n";
    return folder / name;
  }
  // The volumes of the shapes, in order.
  std::vector<double> volumes(const fs::path& file, bool repair = false) {
    run = test::run_node("LoadMesh", {}, {{"path", file.string()}, {"repair", repair ? "true" : "false"}});
    std::vector<double> out;
    for (const Shape& s : run.output<Shapes>("shapes").shapes)
      out.push_back(std::round(s.volume * 1e6) / 1e6);
    return out;
  }
  Diagnostic refusal(const fs::path& file) {
    try {
      volumes(file);
    } catch (const Error& e) {
      return e.diagnostic();
    }
    return {.code = "accepted", .message = {}, .hint = {}, .place = {}, .node = {}, .parameter = {}};
  }
  using Volumes = std::vector<double>;
  const fs::path folder = test::temporary_folder();
  test::NodeRun run;
};

TEST_F(MeshBodies, EachBodyIsAShape) {
  BoxSoup apart, overlapping;
  apart.box({0, 0, 0}, {1, 1, 1}).box({5, 0, 0}, {7, 1, 1}).box({0, 9, 0}, {3, 10, 1});
  EXPECT_EQ(volumes(stl(apart, "three.stl")), (Volumes{1, 2, 3}));
  const auto& shapes = run.output<Shapes>("shapes").shapes;
  EXPECT_EQ(shapes[0].name, "three_1");
  EXPECT_EQ(shapes[2].name, "three_3");
  EXPECT_EQ(shapes[1].probability, 1.0 / 3);
  EXPECT_NEAR(mesh_centroid(shapes[1].mesh).norm(), 0, 1e-12);
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_EQ(run.warnings[0], "three.stl contains 3 bodies of 1 to 3 mm³; each becomes a shape");
  overlapping.box({0, 0, 0}, {10, 10, 10}).box({5, 0, 0}, {15, 10, 10});
  EXPECT_EQ(volumes(stl(overlapping)), (Volumes{1000, 1000}));
}

TEST_F(MeshBodies, BodiesThatTouchStayApart) {
  BoxSoup face, edge, corner, stack;
  face.box({0, 0, 0}, {1, 1, 1}).box({1, 0, 0}, {3, 1, 1});
  EXPECT_EQ(volumes(stl(face)), (Volumes{1, 2}));
  EXPECT_EQ(volumes(stl(face), true), (Volumes{1, 2}));  // a repair changes nothing
  edge.box({0, 0, 0}, {1, 1, 1}).box({1, 1, 0}, {3, 2, 1});
  EXPECT_EQ(volumes(stl(edge)), (Volumes{1, 2}));
  corner.box({0, 0, 0}, {1, 1, 1}).box({1, 1, 1}, {3, 2, 2});
  EXPECT_EQ(volumes(stl(corner)), (Volumes{1, 2}));
  // Eight triangles at the edge in the middle.
  stack.box({0, 0, 0}, {1, 1, 1})
      .box({1, 0, 0}, {2, 1, 1})
      .box({0, 1, 0}, {1, 2, 1})
      .box({1, 1, 0}, {2, 2, 1});
  EXPECT_EQ(volumes(stl(stack)), (Volumes{1, 1, 1, 1}));
}

TEST_F(MeshBodies, ASurfaceThatFacesInwardIsACavity) {
  BoxSoup hollow;
  hollow.box({2, 2, 2}, {3, 3, 3}, true).box({0, 0, 0}, {5, 5, 5}).box({20, 0, 0}, {21, 1, 1});
  EXPECT_EQ(volumes(stl(hollow)), (Volumes{124, 1}));
  // A body in the cavity of another.
  hollow.box({2.25, 2.25, 2.25}, {2.75, 2.75, 2.75});
  EXPECT_EQ(volumes(stl(hollow)), (Volumes{124, 1, 0.125}));
  // The cavity belongs to the inner one of two nested bodies.
  BoxSoup nested;
  nested.box({0, 0, 0}, {5, 5, 5}).box({1, 1, 1}, {4, 4, 4}).box({2, 2, 2}, {3, 3, 3}, true);
  EXPECT_EQ(volumes(stl(nested)), (Volumes{125, 26}));
}

TEST_F(MeshBodies, WhatIsInsideOutIsNamedAndTurned) {
  BoxSoup soup;
  soup.box({0, 0, 0}, {5, 5, 5}).box({7, 0, 0}, {8, 1, 1}, true);
  const auto d = refusal(stl(soup));
  EXPECT_EQ(d.code, "inside-out");
  EXPECT_NE(d.message.find("1 of 2 surfaces face inward and lie in no body, the first at (7, 0, 0)"),
            std::string::npos)
      << d.message;
  EXPECT_EQ(volumes(stl(soup), true), (Volumes{125, 1}));
  EXPECT_EQ(run.warnings.at(0), "a.stl: flipped 12 triangles");
  BoxSoup all;
  all.box({0, 0, 0}, {5, 5, 5}, true).box({1, 1, 1}, {2, 2, 2});
  EXPECT_EQ(volumes(stl(all), true), (Volumes{124}));
}

TEST_F(MeshBodies, SurfacesWithoutVolumeAreDroppedByARepair) {
  BoxSoup soup;
  soup.box({0, 0, 0}, {1, 1, 1});
  soup.add({5, 0, 0}, {6, 0, 0}, {5, 1, 0}, false);
  soup.add({5, 0, 0}, {6, 0, 0}, {5, 1, 0}, true);
  EXPECT_NE(refusal(stl(soup)).message.find("1 of 2 surfaces enclose no volume"), std::string::npos);
  EXPECT_EQ(volumes(stl(soup), true), (Volumes{1}));
}

// A sphere of radius 0.3 at coordinates of UTM. In single precision they are multiples of 0.03 and 0.5.
TEST_F(MeshBodies, FarFromTheOriginNoDigitIsLost) {
  Mesh sphere = geodesic_sphere(3);
  for (Vec3& v : sphere.vertices) v *= 0.3;
  const double expected = mesh_volume(sphere);
  const auto written = [&](const char* extension) {
    const fs::path file = folder / (std::string("utm") + extension);
    std::ofstream out(file);
    const bool ply = file.extension() == ".ply";
    if (ply)
      out << "ply\nformat ascii 1.0\nelement vertex " << sphere.vertices.size()
          << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
          << sphere.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3& v : sphere.vertices)
      out << fmt::format("{}{:.6f} {:.6f} {:.6f}\n", ply ? "" : "v ", v.x() + 452317.5, v.y() + 5411873.25,
                         v.z() + 312.5);
    for (const auto& [a, b, c] : sphere.triangles)
      out << (ply ? fmt::format("3 {} {} {}\n", a, b, c) : fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1));
    return file;
  };
  for (const char* extension : {".obj", ".ply"}) {
    const auto v = volumes(written(extension));
    ASSERT_EQ(v.size(), 1u);
    EXPECT_NEAR(v[0] / expected, 1, 1e-4) << extension;
  }
}

// Files whose writers computed the same corner twice.
TEST_F(MeshBodies, RoundingOfSinglePrecisionDoesNotOpenASurface) {
  BoxSoup soup;
  soup.box({0.1, 0.2, 0.3}, {1.1, 1.2, 1.3});
  int n = 0;
  for (auto& t : soup.triangles)
    for (Vec3& v : t) v.x() += 2e-8 * (n++ % 3);
  EXPECT_EQ(volumes(stl(soup)).size(), 1u);
  EXPECT_TRUE(run.warnings.empty());
}

TEST_F(MeshBodies, ReportedFiles) {
  const auto data = test::shared_data();
  if (data.empty() || !fs::exists(data / "reports")) GTEST_SKIP() << "the shared data is absent";
  EXPECT_EQ(volumes(data / "reports/overlapping_bodies.stl"), (Volumes{1000, 1000}));
  EXPECT_EQ(run.output<Shapes>("shapes").shapes.at(1).name, "overlapping_bodies_2");
  EXPECT_NEAR(volumes(data / "reports/utm_sphere_r0.3m.obj").at(0), 0.10990, 1e-5);
  for (const char* name : {"Solid_unity.stl", "solid_binary_trailing.stl", "tristrips.ply"})
    EXPECT_EQ(volumes(data / "reports" / name), (Volumes{1000})) << name;
}

}  // namespace
}  // namespace terrazzo
