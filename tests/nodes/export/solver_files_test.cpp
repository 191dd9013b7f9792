// Files that solvers run, and the table of materials that they need.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "nodes/data/table.h"
#include "nodes/export/formats/solvers/materials.h"
#include "tests/nodes/export/voxel_files.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace exporting;
using test::content_of;
using test::exported;
using test::lines_of;
namespace fs = std::filesystem;

// Materials of the formula volume: the binder, three classes and the void.
Table some_materials() {
  Table t;
  t.columns = {"phase",     "name",    "lattice",  "c/a",      "density kg/m³",
               "young GPa", "poisson", "C_11 GPa", "C_12 GPa", "C_44 GPa"};
  const std::string none;
  t.rows = {{"BINDER", "Glass", none, none, 2500.0, 70.0, 0.2, none, none, none},
            {"PHASE_0", "Iron", "cI", none, 7870.0, none, none, 233.3, 135.5, 118.0},
            {"PHASE_1", none, "hP", 1.6, 1740.0, 45.0, 0.3, none, none, none},
            {"PHASE_2", none, "cF", none, 2700.0, none, none, 106.75, 60.41, 28.34},
            {"VOIDS", none, none, none, none, 0.01, 0.0, none, none, none}};
  return t;
}

test::Inputs with_materials(const Table& table = some_materials()) {
  Particles p = test::formula_particles();
  for (int i = 0; i < 7; ++i) p.orientation[i] = Quat(Eigen::AngleAxisd(0.4 * i, Vec3(1, 2, 3).normalized()));
  return {{"volume", Value::of(test::formula_volume())},
          {"particles", Value::of(p)},
          {"table", Value::of(table)}};
}

std::string code_with(const std::string& name, const Table& table, test::Parameters parameters = {}) {
  return test::code_of([&] { exported(name, with_materials(table), parameters); });
}

Table changed(std::size_t row, const std::string& column, Table::Cell cell) {
  Table t = some_materials();
  t.rows[row][t.column(column)] = std::move(cell);
  return t;
}

TEST(SolverMaterials, ReadsIsotropicAndCrystalStiffness) {
  const SolverMaterials all(some_materials());
  const Stiffness glass = *all.of("BINDER").stiffness;
  EXPECT_TRUE(glass.isotropic());
  EXPECT_NEAR(glass.c11, 70 * 0.8 / (1.2 * 0.6), 1e-9);
  EXPECT_NEAR(glass.c44, 70 / 2.4, 1e-9);
  const Stiffness iron = *all.of("PHASE_0").stiffness;
  EXPECT_FALSE(iron.isotropic());
  EXPECT_EQ(iron.c33, 233.3);
  EXPECT_EQ(iron.c66, 118.0);
  EXPECT_EQ(all.of("PHASE_1").name, "PHASE_1");
}

TEST(SolverMaterials, RejectsWhatNoSolverCouldUse) {
  EXPECT_EQ(code_with("a.vti", changed(0, "young GPa", -1.0)), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "poisson", 0.5)), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "poisson", std::string())), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "young GPa", std::string("hard"))), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "young GPa", double(NAN))), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "phase", std::string("PHASE"))), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "phase", 3.0)), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(0, "phase", std::string("PHASE_0"))), "bad-materials");  // twice
  EXPECT_EQ(code_with("a.vti", changed(0, "name", std::string("Iron"))), "bad-names");
  EXPECT_EQ(code_with("a.inp", changed(0, "name", std::string("IRON"))), "bad-names");
  EXPECT_EQ(code_with("a.vti", changed(0, "name", std::string("two words"))), "bad-names");
  EXPECT_EQ(code_with("a.vti", changed(1, "lattice", std::string("fcc"))), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(1, "lattice", std::string("oP"))),
            "bad-materials");                                                     // other constants
  EXPECT_EQ(code_with("a.vti", changed(1, "C_12 GPa", 240.0)), "bad-materials");  // not stable
  EXPECT_EQ(code_with("a.vti", changed(1, "young GPa", 200.0)), "bad-materials");
  EXPECT_EQ(code_with("a.vti", changed(2, "c/a", std::string())), "bad-materials");  // DAMASK needs it
  EXPECT_EQ(code_with("a.vti", changed(2, "lattice", std::string("aP"))),
            "bad-materials");  // unknown to DAMASK
  EXPECT_EQ(code_with("a.inp", changed(2, "lattice", std::string("aP"))), "");
  Table t = some_materials();
  t.columns[3] = "ca";
  EXPECT_EQ(code_with("a.vti", t), "bad-materials");
  t.columns[0] = "c/a";
  t.columns[3] = "name";
  EXPECT_EQ(code_with("a.vti", t), "no-column");
  t = some_materials();
  t.rows.pop_back();
  for (const char* name : {"a.vti", "a.inp", "a.dream3d"})
    EXPECT_EQ(code_with(name, t), "no-material") << name;
  t = changed(0, "young GPa", std::string());
  t.rows[0][t.column("poisson")] = std::string();
  for (const char* name : {"a.vti", "a.inp"}) EXPECT_EQ(code_with(name, t), "no-material") << name;
  EXPECT_EQ(code_with("a.dream3d", t), "");
}

TEST(SolverMaterials, CrystalsNeedOrientations) {
  for (const char* name : {"a.vti", "a.inp"}) {
    EXPECT_EQ(code_with(name, some_materials(), {{"regions", "phases"}}), "no-orientations") << name;
    Table t = some_materials();
    t.rows.erase(t.rows.begin() + 2, t.rows.end());
    EXPECT_EQ(test::code_of([&] {
                exported(name, {{"volume", Value::of(test::formula_volume())}, {"table", Value::of(t)}});
              }),
              "no-orientations")
        << name;
  }
}

TEST(SolverFiles, WarnOfCrystalsThatWereNeverTurned) {
  test::Inputs inputs = with_materials();
  inputs.erase("particles");
  inputs.emplace("particles", Value::of(test::formula_particles()));
  EXPECT_EQ(test::run_node("Export", inputs, {{"path", "a.vti"}}, test::temporary_folder()).warnings.size(),
            1u);
  EXPECT_EQ(test::run_node("Export", with_materials(), {{"path", "a.vti"}}, test::temporary_folder())
                .warnings.size(),
            0u);
}

// A volume of particles alone, as of polycrystals.
Volume without_binder() {
  Volume v = test::formula_volume();
  const auto id = v.find<openvdb::Int32Grid>("id")->deepCopy();
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x)
        if (test::formula_id(x, y, z) < 0) id->tree().setValue(openvdb::Coord(x, y, z), 6);
  v.grids = {id};
  return v;
}

TEST(SolverFiles, CountMaterialsFromZeroWithoutAnEmptyBinder) {
  test::Inputs inputs = with_materials();
  inputs.erase("volume");
  inputs.emplace("volume", Value::of(without_binder()));
  const fs::path file = exported("a.vti", inputs);
  const auto material = test::loaded(file, {{"grid", "material"}}).find<openvdb::Int32Grid>("material");
  const int numbers[] = {0, 1, 2, 3, -1, 4, 5};  // particle 4 has no voxel
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const int id = test::formula_id(x, y, z);
        ASSERT_EQ(material->tree().getValue(openvdb::Coord(x, y, z)), numbers[id < 0 ? 6 : id]);
      }
  EXPECT_EQ(lines_of(file.string() + ".csv").size(), 1u + 6);
  std::vector<std::string> phases;
  for (const std::string& line : lines_of(file.parent_path() / "a_material.yaml"))
    if (const auto at = line.find("{phase: \""); at != std::string::npos)
      phases.push_back(line.substr(at + 9, line.find('"', at + 9) - at - 9));
  EXPECT_EQ(phases, (std::vector<std::string>{"Iron", "PHASE_1", "PHASE_2", "VOIDS", "PHASE_2", "Iron"}));
}

TEST(SolverFiles, InpSectionsCoverEveryElementSet) {
  const fs::path file = exported("a.inp", with_materials());
  std::set<std::string> elements, sections, axes;
  for (const char* name : {"a.inp", "a_materials.inp"})
    for (const std::string& line : lines_of(file.parent_path() / name)) {
      const std::string last = line.substr(line.rfind('=') + 1);
      if (line.starts_with("*ELEMENT,")) elements.insert(last);
      if (line.starts_with("*ORIENTATION,")) axes.insert(last);
      if (line.starts_with("*SOLID SECTION, ELSET="))
        sections.insert(line.substr(22, line.find(',', 22) - 22));
    }
  EXPECT_EQ(elements, sections);
  EXPECT_EQ(axes, (std::set<std::string>{"AXES_PARTICLE_0", "AXES_PARTICLE_2", "AXES_PARTICLE_5",
                                         "AXES_PARTICLE_6"}));
  const fs::path out = test::temporary_folder();
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Export", with_materials(), {{"path", "two words.inp"}}, out);
            }),
            "bad-names");
  EXPECT_TRUE(fs::is_empty(out));
}

TEST(SolverFiles, TesrHoldsCellsAndOrientations) {
  const auto turn = [](double degrees, const Vec3& axis) {
    return Eigen::AngleAxisd(degrees * M_PI / 180, axis);
  };
  Particles p = test::formula_particles();
  p.orientation[0] = turn(30, Vec3::UnitZ()) * turn(40, Vec3::UnitX()) * turn(50, Vec3::UnitZ());
  test::Inputs inputs = with_materials();
  inputs.erase("particles");
  inputs.emplace("particles", Value::of(p));
  const auto lines = lines_of(exported("a.tesr", inputs));
  ASSERT_GT(lines.size(), 22u);
  EXPECT_EQ(lines[0], "***tesr");
  EXPECT_EQ(lines[5], "   6 5 4");
  EXPECT_EQ(lines[6], "   0.25 0.25 0.25");
  EXPECT_EQ(lines[13], "   30.000000000000 40.000000000000 50.000000000000");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "  *crysym"), 0);  // hexagonal and cubic
  EXPECT_EQ(lines[10], "   5");                                       // without particles 3, a void, and 4
  const auto data = std::find(lines.begin(), lines.end(), "   ascii");
  const int numbers[] = {1, 2, 3, 0, -1, 4, 5};
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y) {
      std::istringstream row(*(data + 1 + y + 5 * z));
      for (int x = 0; x < 6; ++x) {
        int cell = -1;
        const int id = test::formula_id(x, y, z);
        ASSERT_TRUE(row >> cell);
        ASSERT_EQ(cell, id < 0 ? 0 : numbers[id]);
      }
    }
  EXPECT_EQ(lines.back(), "***end");
  const auto cubic = lines_of(exported("a.tesr", with_materials(changed(2, "lattice", std::string("cF")))));
  const auto symmetry = std::find(cubic.begin(), cubic.end(), "  *crysym");
  ASSERT_NE(symmetry, cubic.end());
  EXPECT_EQ(*(symmetry + 1), "   cubic");
}

TEST(SolverFiles, LammpsSpheresHaveTheParticlesVolumes) {
  Particles p = test::some_particles(20);
  p.voids.assign(20, 0);
  p.voids[7] = 1;
  const auto lines = lines_of(exported("a.lmp", {{"particles", Value::of(p)},
                                                 {"shapes", Value::of(test::two_shapes())},
                                                 {"table", Value::of(some_materials())}}));
  ASSERT_EQ(lines.size(), 11u + 19);
  EXPECT_EQ(lines[2], "19 atoms");
  EXPECT_EQ(lines[6], "0 0.03 ylo yhi");
  const double densities[] = {7870, 1740, 2700};
  for (std::size_t k = 0, i = 0; k < 19; ++k, ++i) {
    if (i == 7) ++i;
    std::istringstream row(lines[11 + k]);
    double atom = 0, type = 0, diameter = 0, density = 0, x = 0;
    ASSERT_TRUE(row >> atom >> type >> diameter >> density >> x);
    EXPECT_EQ(atom, double(k + 1));
    EXPECT_EQ(type, p.cls[i] + 1);
    EXPECT_EQ(density, densities[p.cls[i]]);
    EXPECT_NEAR(std::pow(diameter, 3) * M_PI / 6, 8.0 / 3 * std::pow(p.scale[i], 3) * 1e-9, 1e-17);
    EXPECT_NEAR(x, p.position[i].x() * 1e-3, 1e-12);
  }
  Table t = changed(1, "density kg/m³", std::string());
  EXPECT_EQ(test::code_of([&] {
              exported("a.lmp", {{"particles", Value::of(p)},
                                 {"shapes", Value::of(test::two_shapes())},
                                 {"table", Value::of(t)}});
            }),
            "no-material");
}

TEST(SolverFiles, FoamNeedsBinder) {
  EXPECT_EQ(test::code_of([&] {
              exported("case/a.foam", {{"volume", Value::of(without_binder())}});
            }),
            "no-binder");
}

}  // namespace
}  // namespace terrazzo
