// Files for solvers, read or run by programs that others wrote.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "tests/nodes/export/export_support.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

Table crystals() {
  Table t;
  t.columns = {"phase", "name", "lattice", "C_11 GPa", "C_12 GPa", "C_44 GPa", "density kg/m³"};
  for (int k = 0; k < 3; ++k)
    t.rows.push_back(
        {"PHASE_" + std::to_string(k), "Metal-" + std::to_string(k), "cF", 106.75, 60.41, 28.34, 2700.0});
  return t;
}

fs::path export_to(const std::string& name, const std::multimap<std::string, Value>& inputs,
                   std::map<std::string, std::string> parameters = {}) {
  const fs::path out = test::temporary_folder();
  parameters["path"] = name;
  test::run_node("Export", inputs, parameters, out);
  return out / name;
}

// DAMASK's rules: unit quaternions with a positive real part, in the order of the numbers in the grid, of the
// rotation with Bunge's angles: q = (cos Φ/2 cos σ, sin Φ/2 cos δ, sin Φ/2 sin δ, cos Φ/2 sin σ).
TEST(ExportedSolvers, MaterialYamlIsReadByPyYaml) {
  if (!test::has_python_module("yaml")) GTEST_SKIP() << "python3-yaml is not installed";
  Particles p = test::formula_particles();
  p.voids.clear();
  const double phi1 = 0.3, phi = 0.5, phi2 = 5.7;
  p.orientation[1] = Quat(Eigen::AngleAxisd(phi1, Vec3::UnitZ()) * Eigen::AngleAxisd(phi, Vec3::UnitX()) *
                          Eigen::AngleAxisd(phi2, Vec3::UnitZ()));
  Table t = crystals();
  t.columns.insert(t.columns.end(), {"young GPa", "poisson"});
  for (auto& row : t.rows) row.insert(row.end(), {std::string(), std::string()});
  const std::string none;
  t.rows.push_back({"BINDER", "Glue", none, none, none, none, none, 3.0, 0.35});
  const fs::path file = export_to(
      "a.vti",
      {{"volume", Value::of(test::formula_volume())}, {"particles", Value::of(p)}, {"table", Value::of(t)}});
  const auto j = test::run_reader("read_solver.py", {(file.parent_path() / "a_material.yaml").string()});
  EXPECT_EQ(j["homogenization"]["SX"]["N_constituents"], 1);
  EXPECT_EQ(j["phase"].size(), 4u);
  EXPECT_EQ(j["phase"]["Metal-2"]["lattice"], "cF");
  EXPECT_EQ(j["phase"]["Metal-2"]["mechanical"]["elastic"]["C_44"], 28.34e9);
  EXPECT_EQ(j["phase"]["Metal-2"]["rho"], 2700);
  const auto& glue = j["phase"]["Glue"]["mechanical"]["elastic"];
  EXPECT_NEAR(glue["C_44"], (glue["C_11"].get<double>() - glue["C_12"].get<double>()) / 2, 1);
  const char* phases[] = {"Glue", "Metal-0", "Metal-1", "Metal-2", "Metal-0", "Metal-2", "Metal-0"};
  ASSERT_EQ(j["material"].size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    const auto& constituent = j["material"][k]["constituents"][0];
    EXPECT_EQ(constituent["phase"], phases[k]);
    double norm = 0;
    for (const auto& q : constituent["O"]) norm += q.get<double>() * q.get<double>();
    EXPECT_NEAR(norm, 1, 1e-14);
    EXPECT_GE(constituent["O"][0], 0);
  }
  const double c = std::cos(phi / 2), s = std::sin(phi / 2), sum = (phi1 + phi2) / 2,
               half = (phi1 - phi2) / 2;
  double q[] = {c * std::cos(sum), s * std::cos(half), s * std::sin(half), c * std::sin(sum)};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(j["material"][2]["constituents"][0]["O"][k], q[0] < 0 ? -q[k] : q[k], 1e-14);
  const auto load = test::run_reader("read_solver.py", {(file.parent_path() / "a_load.yaml").string()});
  const auto& mechanical = load["loadstep"][0]["boundary_conditions"]["mechanical"];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)  // one of them is given at each place
      EXPECT_NE(mechanical["dot_F"][i][k].is_string(), mechanical["P"][i][k].is_string());
}

TEST(ExportedSolvers, UnstructuredGridsOpenInVtk) {
  if (!test::has_python_module("vtkmodules.vtkFiltersVerdict"))
    GTEST_SKIP() << "python3-vtk9 is not installed";
  for (const char* compression : {"zlib", "none"}) {
    const fs::path file = export_to(
        "a.vtu",
        {{"volume", Value::of(test::formula_volume())}, {"particles", Value::of(test::formula_particles())}},
        {{"compression", compression}});
    const auto j = test::run_reader("read_solver.py", {file.string()});
    const double edges[] = {1.5e-3, 1.25e-3, 1e-3};
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(j["bounds"][2 * a + 1], edges[a], 1e-15);
    ASSERT_EQ(j["volumes"].size(), 120u);
    for (const auto& v : j["volumes"]) EXPECT_NEAR(v.get<double>() * 1e12, 250.0 * 250 * 250 * 1e-6, 1e-9);
    const int numbers[] = {1, 2, 3, 4, -1, 5, 6};
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 6; ++x) {
          const int id = test::formula_id(x, y, z);
          ASSERT_EQ(j["material"][std::size_t((z * 5 + y) * 6 + x)], id < 0 ? 0 : numbers[id]);
        }
    for (int a = 0; a < 3; ++a)
      for (const auto& step : j["steps"][std::string(1, "XYZ"[a])])
        for (int b = 0; b < 3; ++b) EXPECT_NEAR(step[std::size_t(b)], a == b ? edges[a] : 0, 1e-15);
  }
}

// Mass and box of the spheres, as the programs find them.
TEST(ExportedSolvers, SpheresAreReadByLammpsAndLiggghts) {
  const bool lammps = test::has_program("lmp"), liggghts = test::has_program("liggghts");
  if (!lammps && !liggghts)
    GTEST_SKIP() << "lammps and liggghts are not installed; ./dev test --all installs them";
  const Particles p = test::some_particles(40);
  const fs::path file = export_to("a.lmp", {{"particles", Value::of(p)},
                                            {"shapes", Value::of(test::two_shapes())},
                                            {"table", Value::of(crystals())}});
  double mass = 0;
  for (const double s : p.scale) mass += 2700 * 8.0 / 3 * s * s * s * 1e-9;
  const fs::path folder = file.parent_path();
  if (lammps) {
    std::ofstream(folder / "in.lmp")
        << "units si\natom_style sphere\nread_data a.lmp\npair_style zero 0.001\n"
           "pair_coeff * *\nrun 0\nvariable m equal mass(all)\n"
           "print \"found $(atoms) $(lz) $m\"\n";
    const auto run = test::run_command({"lmp", "-in", "in.lmp"}, {.folder = folder});
    std::istringstream words(run.out.substr(std::min(run.out.size(), run.out.rfind("found ") + 6)));
    double atoms = 0, lz = 0, m = 0;
    ASSERT_TRUE(words >> atoms >> lz >> m) << run.out << run.err;
    EXPECT_EQ(atoms, 40);
    EXPECT_NEAR(lz, 0.04, 1e-12);
    EXPECT_NEAR(m / mass, 1, 1e-9);
  }
  if (!liggghts) return;
  std::ofstream(folder / "in.lig") << "units si\natom_style granular\nboundary p p p\nnewton "
                                      "off\ncommunicate single vel yes\nread_data a.lmp\n";
  const auto run = test::run_command({"liggghts", "-in", "in.lig"}, {.folder = folder});
  EXPECT_NE(run.out.find("  40 atoms"), std::string::npos) << run.out << run.err;
}

// Balls at the center and the corners of a periodic box; the patches are the classes.
TEST(ExportedSolvers, OpenFoamMeshesThePores) {
  if (!test::has_program("snappyHexMesh"))
    GTEST_SKIP() << "openfoam is not installed; ./dev test --all installs it";
  initialize_openvdb();
  constexpr int kN = 20;
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  id->setTransform(voxel_transform(0.1));
  const Vec3 centers[] = {{10, 10, 10}, {0, 0, 0}};
  std::size_t binder = 0;
  for (int z = 0; z < kN; ++z)
    for (int y = 0; y < kN; ++y)
      for (int x = 0; x < kN; ++x) {
        int found = -1;
        for (int b = 0; b < 2; ++b) {
          Vec3 d = Vec3(x + 0.5, y + 0.5, z + 0.5) - centers[b];
          for (int a = 0; a < 3; ++a) d[a] -= kN * std::round(d[a] / kN);
          if (d.norm() < 7) found = b;
        }
        if (found >= 0) id->tree().setValue(openvdb::Coord(x, y, z), found);
        binder += found < 0;
      }
  Volume volume;
  volume.resolution = Vec3i::Constant(kN);
  volume.grids = {id};
  Particles p;
  p.box = Vec3::Constant(2);
  p.resize(2);
  p.cls = {0, 1};
  const fs::path folder = export_to("flow.foam", {{"volume", Value::of(volume)}, {"particles", Value::of(p)}},
                                    {{"regions", "phases"}})
                              .parent_path();
  const auto run = test::run_command({"/bin/sh", "-c",
                                      "WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam}; export "
                                      "WM_PROJECT_DIR; blockMesh && snappyHexMesh "
                                      "-overwrite && checkMesh"},
                                     {.folder = folder});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("\nMesh OK."), std::string::npos) << run.out;
  for (const char* patch : {" X0 ", " Z1 ", " PHASE_0 ", " PHASE_1 "})
    EXPECT_NE(run.out.find(patch, run.out.find("Checking patch topology")), std::string::npos) << patch;
  const auto at = run.out.rfind("Total volume = ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NEAR(std::stod(run.out.substr(at + 15)) / (double(binder) * 1e-12), 1, 0.05);
}

}  // namespace
}  // namespace terrazzo
