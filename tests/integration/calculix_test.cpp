// Solves exported meshes with CalculiX, where the exact stresses are known, and reads them with meshio.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

constexpr int kX = 4, kY = 3, kZ = 2;  // voxels of 0.5 mm
constexpr double kLength = 0.5 * kX;   // mm along x
using Stress = std::array<double, 6>;  // MPa: xx, yy, zz, xy, xz, yz

// Particle 0 fills the voxels with x ≥ 1, if there is one; the rest is binder: layers across x.
Volume layers(bool particle) {
  initialize_openvdb();
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  id->setTransform(voxel_transform(0.5));
  for (int z = 0; z < kZ && particle; ++z)
    for (int y = 0; y < kY; ++y)
      for (int x = 1; x < kX; ++x) id->tree().setValue(openvdb::Coord(x, y, z), 0);
  Volume v;
  v.resolution = Vec3i(kX, kY, kZ);
  v.grids = {id};
  return v;
}

fs::path mesh_of(const Volume& v) {
  const fs::path out = test::temporary_folder();
  test::run_node("Export", {{"volume", Value::of(v)}}, {{"path", "mesh.inp"}}, out);
  return out;
}

struct Elastic {
  double young, poisson;  // MPa
};
std::string material(const std::string& set, const Elastic& e) {
  std::ostringstream out;
  out << "*MATERIAL, NAME=M_" << set << "\n*ELASTIC\n"
      << e.young << ", " << e.poisson << "\n*SOLID SECTION, ELSET=" << set << ", MATERIAL=M_" << set << "\n";
  return out.str();
}

// Stresses at the integration points of each element.
std::map<int, std::vector<Stress>> solve(const fs::path& folder, const std::string& materials,
                                         const std::string& boundary, bool periodic,
                                         std::size_t elements = kX * kY * kZ) {
  std::ofstream(folder / "job.inp") << "*INCLUDE, INPUT=mesh.inp\n"
                                    << (periodic ? "*INCLUDE, INPUT=mesh_periodic.inp\n" : "") << materials
                                    << "*STEP\n*STATIC\n*BOUNDARY\n"
                                    << boundary << "*EL PRINT, ELSET=ALL_ELEMENTS\nS\n*END STEP\n";
  const auto run = test::run_command({"ccx", "-i", "job"}, {.folder = folder});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  std::map<int, std::vector<Stress>> stresses;
  std::ifstream in(folder / "job.dat");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    int element = 0, point = 0;
    Stress s;
    if (words >> element >> point >> s[0] >> s[1] >> s[2] >> s[3] >> s[4] >> s[5])
      stresses[element].push_back(s);
  }
  EXPECT_EQ(stresses.size(), elements) << run.out;
  return stresses;
}

void expect_uniform(const std::map<int, std::vector<Stress>>& stresses, const Stress& expected) {
  for (const auto& [element, points] : stresses) {
    EXPECT_EQ(points.size(), 8u);
    for (const Stress& s : points)
      for (int k = 0; k < 6; ++k) EXPECT_NEAR(s[k], expected[k], 1e-4) << "element " << element << ", " << k;
  }
}

constexpr const char* kPull =
    "SIDE_X0, 1, 1, 0.\nSIDE_Y0, 2, 2, 0.\nSIDE_Z0, 3, 3, 0.\nSIDE_X1, 1, 1, 0.002\n";

TEST(CalculiX, SolvesThePatchTestExactly) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  const fs::path folder = mesh_of(layers(false));
  const double strain = 0.002 / kLength;
  expect_uniform(solve(folder, material("BINDER", {1000, 0.3}), kPull, false),
                 {1000 * strain, 0, 0, 0, 0, 0});
}

// Without Poisson's effect the layers are springs in series: σ = ε / (f₁/E₁ + f₂/E₂).
TEST(CalculiX, PullsTwoPhasesInSeries) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  const fs::path folder = mesh_of(layers(true));
  const std::string materials = material("BINDER", {500, 0}) + material("PARTICLES", {4000, 0});
  const double sigma = 0.002 / kLength / (0.25 / 500 + 0.75 / 4000);
  expect_uniform(solve(folder, materials, kPull, false), {sigma, 0, 0, 0, 0, 0});
}

// Along the layers they are parallel: σᵢ = Eᵢ·ε. The element sets decide which has which.
TEST(CalculiX, PullsTwoPhasesInParallel) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  const fs::path folder = mesh_of(layers(true));
  const std::string materials = material("BINDER", {500, 0}) + material("PARTICLE_0", {4000, 0});
  const auto stresses =
      solve(folder, materials,
            "SIDE_X0, 1, 1, 0.\nSIDE_Y0, 2, 2, 0.\nSIDE_Z0, 3, 3, 0.\nSIDE_Y1, 2, 2, 0.003\n", false);
  for (const auto& [element, points] : stresses) {
    const double young = (element - 1) % kX >= 1 ? 4000 : 500;
    for (const Stress& s : points) EXPECT_NEAR(s[1], young * 0.003 / (0.5 * kY), 1e-4) << element;
  }
}

// A mean shear of periodic layers: the same shear stress everywhere, γ / (f₁/G₁ + f₂/G₂).
TEST(CalculiX, ShearsAPeriodicLaminateExactly) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  const fs::path folder = mesh_of(layers(true));
  const std::string materials = material("BINDER", {520, 0.3}) + material("PARTICLES", {4000, 0.25});
  // u_y = γ·x; the other corners do not move.
  const std::string corners =
      "CORNER_000, 1, 3, 0.\nCORNER_010, 1, 3, 0.\nCORNER_001, 1, 3, 0.\n"
      "CORNER_100, 1, 1, 0.\nCORNER_100, 2, 2, 0.004\nCORNER_100, 3, 3, 0.\n";
  const double gamma = 0.004 / kLength, g1 = 520 / 2.6, g2 = 4000 / 2.5;
  expect_uniform(solve(folder, materials, corners, true), {0, 0, 0, gamma / (0.25 / g1 + 0.75 / g2), 0, 0});
}

TEST(CalculiX, StretchesAPeriodicBlockUniformly) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  const fs::path folder = mesh_of(layers(false));
  // Free corners may contract: uniaxial stress along x.
  const std::string corners =
      "CORNER_000, 1, 3, 0.\nCORNER_100, 1, 1, 0.002\nCORNER_100, 2, 3, 0.\nCORNER_010, 1, 1, 0.\n"
      "CORNER_010, 3, 3, 0.\nCORNER_001, 1, 2, 0.\n";
  expect_uniform(solve(folder, material("BINDER", {1000, 0.3}), corners, true),
                 {1000 * 0.002 / kLength, 0, 0, 0, 0, 0});
}

// A periodic cube of 8³ voxels, of which a third are particles at random.
Volume random_cube(int n) {
  initialize_openvdb();
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  id->setTransform(voxel_transform(0.5));
  for (int i = 0; i < n * n * n; ++i)
    if (Random(1, 1, i).uniform() < 1.0 / 3)
      id->tree().setValue(openvdb::Coord(i % n, i / n % n, i / n / n), 0);
  Volume v;
  v.resolution = Vec3i(n, n, n);
  v.grids = {id};
  return v;
}

// Every entry of the effective stiffness, from the same trilinear elements.
TEST(CalculiX, FindsTheStiffnessOfHomogenize) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  constexpr int kEdge = 8;
  const Volume cube = random_cube(kEdge);
  const auto ours = test::run_node(
      "Homogenize", {{"volume", Value::of(cube)}},
      {{"property", "stiffness"}, {"values", "[1000, 0.3, 20000, 0.2]"}, {"tolerance", "1e-6"}});
  const Table& tensor = ours.output<Table>("tensor");
  const fs::path folder = mesh_of(cube);
  const std::string materials = material("BINDER", {1000, 0.3}) + material("PARTICLES", {20000, 0.2});
  constexpr std::array<std::array<int, 2>, 6> kVoigt = {{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  constexpr std::array<int, 6> kPrinted = {0, 1, 2, 5, 4, 3};  // CalculiX's place of Voigt's entries
  for (int load = 0; load < 6; ++load) {
    const auto [a, b] = kVoigt[load];
    Mat3 strain = Mat3::Zero();
    strain(a, b) = strain(b, a) = a == b ? 0.001 : 0.0005;
    std::ostringstream corners;
    corners << "CORNER_000, 1, 3, 0.\n";
    for (int axis = 0; axis < 3; ++axis)
      for (int c = 0; c < 3; ++c)
        corners << "CORNER_" << (axis == 0) << (axis == 1) << (axis == 2) << ", " << c + 1 << ", " << c + 1
                << ", " << strain(c, axis) * 0.5 * kEdge << "\n";
    Stress mean{};
    for (const auto& [element, points] : solve(folder, materials, corners.str(), true, kEdge * kEdge * kEdge))
      for (const Stress& s : points)
        for (int k = 0; k < 6; ++k) mean[k] += s[k] / (8.0 * kEdge * kEdge * kEdge);
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(mean[kPrinted[k]] / 0.001, std::get<double>(tensor.rows[k][load]),
                  2e-5 * std::get<double>(tensor.rows[0][0]))
          << k << ", " << load;
  }
}

TEST(Meshio, ReadsTheMeshAndItsSets) {
  if (!test::has_python_module("meshio"))
    GTEST_SKIP() << "python3-meshio is not installed; ./dev test --all installs it";
  const fs::path out = test::temporary_folder();
  test::run_node(
      "Export",
      {{"volume", Value::of(test::formula_volume())}, {"particles", Value::of(test::formula_particles())}},
      {{"path", "a b.inp"}}, out);
  const auto j = test::run_reader("read_inp.py", {(out / "a b.inp").string()});
  ASSERT_TRUE(j.is_object());
  ASSERT_EQ(j["points"].size(), 7u * 6 * 5);
  EXPECT_EQ(j["points"].back(), nlohmann::json({1.5, 1.25, 1.0}));
  const auto& p = j["points"];
  double volume = 0;
  std::size_t elements = 0;
  for (const auto& block : j["cells"]) {
    EXPECT_EQ(block[0], "hexahedron");
    for (const auto& e : block[1]) {
      // Edges from the first node to nodes 2, 4 and 5 are right-handed.
      Mat3 edges;
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
          edges(c, k) =
              p[e[std::array{1, 3, 4}[k]].get<int>()][c].get<double>() - p[e[0].get<int>()][c].get<double>();
      volume += edges.determinant();
      ++elements;
    }
  }
  EXPECT_EQ(elements, 120u);
  EXPECT_NEAR(volume, 1.5 * 1.25 * 1, 1e-9);
  EXPECT_EQ(j["cells"].size(), 7u);  // binder, five particles, a void
  for (const char* name :
       {"BINDER", "PARTICLE_0", "VOID_3", "PHASE_0", "PHASE_2", "VOIDS", "PARTICLES", "ALL_ELEMENTS"})
    EXPECT_TRUE(j["cell_sets"].contains(name)) << name;
  EXPECT_EQ(j["cell_sets"]["ALL_ELEMENTS"].size(), 7u);
  for (const auto& i : j["point_sets"]["FACE_X1"]) EXPECT_EQ(p[i.get<int>()][0], 1.5);
  EXPECT_EQ(j["point_sets"]["FACE_X1"].size(), 4u * 3);
}

// The stiffness of a crystal turned by `turn`, MPa: C_ijkl = R_ia R_jb R_kc R_ld C_abcd.
std::array<double, 81> turned_stiffness(double c11, double c12, double c44, const Mat3& turn) {
  const auto at = [](int i, int j, int k, int l) { return std::size_t(((i * 3 + j) * 3 + k) * 3 + l); };
  std::array<double, 81> crystal{}, out{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      crystal[at(i, i, j, j)] = i == j ? c11 : c12;
      if (i != j) crystal[at(i, j, i, j)] = crystal[at(i, j, j, i)] = c44;
    }
  for (int n = 0; n < 81; ++n)
    for (int m = 0; m < 81; ++m) {
      double factor = crystal[std::size_t(m)];
      for (int digit = 1; digit < 81; digit *= 3) factor *= turn(n / digit % 3, m / digit % 3);
      out[std::size_t(n)] += factor;
    }
  return out;
}

// A single crystal under the job that Export writes: strains xx given, yy and zz free, no shear.
TEST(CalculiX, RunsTheExportedJobOfATurnedCrystal) {
  if (!test::has_program("ccx"))
    GTEST_SKIP() << "calculix-ccx is not installed; ./dev test --all installs it";
  Volume v = layers(true);
  const auto id = v.find<openvdb::Int32Grid>("id")->deepCopy();
  id->denseFill(openvdb::CoordBBox(0, 0, 0, kX - 1, kY - 1, kZ - 1), 0);
  v.grids = {id};
  Particles p;
  p.box = Vec3(0.5 * kX, 0.5 * kY, 0.5 * kZ);
  p.resize(1);
  p.orientation[0] = Quat(0.3, -0.5, 0.7, 0.2).normalized();
  Table t;
  t.columns = {"phase", "name", "lattice", "C_11 GPa", "C_12 GPa", "C_44 GPa"};
  t.rows = {{"PHASE_0", "Copper", "cF", 168.3, 122.1, 75.7}};
  const fs::path folder = test::temporary_folder();
  test::run_node("Export", {{"volume", Value::of(v)}, {"particles", Value::of(p)}, {"table", Value::of(t)}},
                 {{"path", "mesh.inp"}}, folder);
  const auto run = test::run_command({"ccx", "-i", "mesh_job"}, {.folder = folder});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const auto c = turned_stiffness(168300, 122100, 75700, p.orientation[0].toRotationMatrix());
  const auto at = [&](int i, int j, int k) { return c[std::size_t((i * 3 + j) * 9 + 4 * k)]; };
  const double strain = 0.001;
  Eigen::Matrix2d rest;
  rest << at(1, 1, 1), at(1, 1, 2), at(2, 2, 1), at(2, 2, 2);
  const Eigen::Vector2d free = rest.inverse() * (-strain * Eigen::Vector2d(at(1, 1, 0), at(2, 2, 0)));
  const auto stress = [&](int i, int j) {
    return at(i, j, 0) * strain + at(i, j, 1) * free[0] + at(i, j, 2) * free[1];
  };
  const double expected[] = {stress(0, 0), 0, 0, stress(0, 1), stress(0, 2), stress(1, 2)};
  EXPECT_GT(std::abs(expected[3]) + std::abs(expected[4]), 5);
  int found = 0;
  std::ifstream in(folder / "mesh_job.dat");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    int element = 0, point = 0;
    Stress s;
    if (!(words >> element >> point >> s[0] >> s[1] >> s[2] >> s[3] >> s[4] >> s[5])) continue;
    ++found;
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(s[k], expected[k], 1e-3) << k;
  }
  EXPECT_EQ(found, 8 * kX * kY * kZ);
}

}  // namespace
}  // namespace terrazzo
