// DREAM3D files that Export writes, read by h5py; and files that h5py writes, read by LoadVolume.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(ExportedDream3d, OpensInH5pyWithEqualValues) {
  if (!test::has_python_module("h5py")) GTEST_SKIP() << "python3-h5py is not installed";
  const fs::path out = test::temporary_folder();
  Particles particles = test::formula_particles();
  // Bunge's angles (φ1, Φ, φ2) = (0.3, 0.5, 0.7) turn the box into the particle's frame: R = Rz(φ1) Rx(Φ)
  // Rz(φ2).
  particles.orientation[1] =
      Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ()) * Eigen::AngleAxisd(0.5, Vec3::UnitX()) *
           Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  test::run_node("Export",
                 {{"volume", Value::of(test::formula_volume())}, {"particles", Value::of(particles)}},
                 {{"path", "a.dream3d"}}, out);
  const auto j = test::run_reader("read_dream3d.py", {(out / "a.dream3d").string()});
  EXPECT_EQ(j["root"]["FileVersion"], "7.0");
  EXPECT_EQ(j["base"], "DataContainers/ImageDataContainer");
  EXPECT_EQ(j["cell_data"], "CellData");
  EXPECT_EQ(j["geometry"]["DIMENSIONS"]["values"], (std::vector<int>{6, 5, 4}));
  EXPECT_EQ(j["geometry"]["DIMENSIONS"]["type"], "int64");
  EXPECT_EQ(j["geometry"]["SPACING"]["values"], (std::vector<double>{250, 250, 250}));
  EXPECT_EQ(j["geometry"]["SPACING"]["type"], "float32");
  EXPECT_EQ(j["geometry_attributes"]["GeometryTypeName"], "ImageGeometry");
  EXPECT_EQ(j["geometry_attributes"]["Period"], (std::vector<int>{6, 5, 4}));

  const auto& cells = j["matrices"]["CellData"];
  EXPECT_EQ(cells["attributes"]["AttributeMatrixType"], std::vector<int>{3});
  EXPECT_EQ(cells["attributes"]["TupleDimensions"], (std::vector<int>{6, 5, 4}));
  const auto& arrays = cells["arrays"];
  EXPECT_EQ(arrays["FeatureIds"]["shape"], (std::vector<int>{4, 5, 6, 1}));
  EXPECT_EQ(arrays["FeatureIds"]["attributes"]["ObjectType"], "DataArray<int32_t>");
  EXPECT_EQ(arrays["FeatureIds"]["attributes"]["Tuple Axis Dimensions"], "x=6,y=5,z=4");
  EXPECT_EQ(arrays["Cd"]["attributes"]["ComponentDimensions"], std::vector<int>{3});
  const int numbers[] = {1, 2, 3, 4, -1, 5, 6}, phases[] = {1, 2, 3, 4, -1, 3, 1};  // particle 3 is a void
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const auto at = static_cast<std::size_t>((z * 5 + y) * 6 + x);
        const int id = test::formula_id(x, y, z);
        ASSERT_EQ(arrays["FeatureIds"]["values"][at], id < 0 ? 0 : numbers[id]);
        ASSERT_EQ(arrays["Phases"]["values"][at], id < 0 ? 0 : phases[id]);
        ASSERT_EQ(arrays["id"]["values"][at], id);
        ASSERT_EQ(arrays["density"]["values"][at], test::formula_density(x, y, z));
        ASSERT_EQ(arrays["Cd"]["values"][3 * at + 1], 0.25 * x);
        ASSERT_EQ(arrays["source"]["values"][3 * at + 2], z);
      }

  const auto& features = j["matrices"]["CellFeatureData"];
  EXPECT_EQ(features["attributes"]["AttributeMatrixType"], std::vector<int>{7});
  EXPECT_EQ(features["arrays"]["Active"]["values"], (std::vector<int>{0, 1, 1, 1, 1, 1, 1}));
  EXPECT_EQ(features["arrays"]["Particle"]["values"], (std::vector<int>{-1, 0, 1, 2, 3, 5, 6}));
  EXPECT_EQ(features["arrays"]["Phases"]["values"], (std::vector<int>{0, 1, 2, 3, 4, 3, 1}));
  const double angles[] = {0.3, 0.5, 0.7};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(features["arrays"]["EulerAngles"]["values"][6 + k], angles[k], 1e-6);
    EXPECT_EQ(features["arrays"]["EulerAngles"]["values"][3 + k], 0);
  }
  // Quaternions are those of the same rotation from the sample to the crystal, x y z w.
  const Quat inverse = particles.orientation[1].conjugate();
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(features["arrays"]["AvgQuats"]["values"][8 + k],
                inverse.coeffs()[static_cast<Eigen::Index>(k)], 1e-6);
  double elements = 0;
  for (const auto& n : features["arrays"]["NumElements"]["values"]) elements += n.get<double>();
  EXPECT_EQ(elements, 120);
  EXPECT_NEAR(features["arrays"]["Volumes"]["values"][1],
              features["arrays"]["NumElements"]["values"][1].get<double>() * 250 * 250 * 250, 10);

  const auto& ensembles = j["matrices"]["CellEnsembleData"];
  EXPECT_EQ(ensembles["attributes"]["AttributeMatrixType"], std::vector<int>{11});
  EXPECT_EQ(ensembles["arrays"]["PhaseName"]["values"],
            (std::vector<std::string>{"BINDER", "PHASE_0", "PHASE_1", "PHASE_2", "VOIDS"}));
  EXPECT_EQ(ensembles["arrays"]["CrystalStructures"]["type"], "uint32");
}

TEST(ForeignDream3d, OpensInLoadVolume) {
  if (!test::has_python_module("h5py")) GTEST_SKIP() << "python3-h5py is not installed";
  const fs::path out = test::temporary_folder();
  for (const char* mode : {"plain", "chunked", "two"}) {
    const fs::path file = out / (std::string(mode) + ".dream3d");
    test::run_reader("write_dream3d.py", {file.string(), mode});
    const auto run = test::run_node("LoadVolume", {}, {{"path", file.string()}});
    const auto& volume = run.output<Volume>("volume");
    const auto id = volume.find<openvdb::Int32Grid>("id");
    const auto angles = volume.find<openvdb::Vec3SGrid>("EulerAngles");
    const auto mask = volume.find<openvdb::Int32Grid>("Mask");
    ASSERT_TRUE(id && angles && mask) << mode;
    EXPECT_EQ(id->voxelSize()[0], 0.25);
    EXPECT_EQ(volume.resolution, Vec3i::Zero());
    for (int z = 0; z < 2; ++z)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x) {
          const openvdb::Coord at(x, y, z);
          ASSERT_EQ(id->tree().getValue(at), x + 4 * y + 12 * z) << mode;
          ASSERT_EQ(angles->tree().getValue(at), openvdb::Vec3s(float(x), float(y), float(z))) << mode;
          ASSERT_EQ(mask->tree().getValue(at), x % 2) << mode;
        }
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_NE(run.warnings[0].find("'Quats' is left out"), std::string::npos);
  }
  const auto code = [&](const char* mode) {
    const fs::path file = out / "bad.dream3d";
    test::run_reader("write_dream3d.py", {file.string(), mode});
    return test::code_of([&] {
      test::run_node("LoadVolume", {}, {{"path", file.string()}, {"grid", "id"}});
    });
  };
  EXPECT_EQ(code("latest"), "");
  EXPECT_EQ(code("big"), "");  // of another byte order
}

TEST(ExportedDream3d, HasCrystalStructures) {
  if (!test::has_python_module("h5py")) GTEST_SKIP() << "python3-h5py is not installed";
  Table t;
  t.columns = {"phase", "name", "lattice"};
  t.rows = {{"PHASE_2", "Mica", "mS"},
            {"BINDER", "Glass", ""},
            {"PHASE_0", "Iron", "cI"},
            {"PHASE_1", "Zinc", "hP"},
            {"VOIDS", "Air", ""}};
  const fs::path out = test::temporary_folder();
  test::run_node("Export",
                 {{"volume", Value::of(test::formula_volume())},
                  {"particles", Value::of(test::formula_particles())},
                  {"table", Value::of(t)}},
                 {{"path", "a.dream3d"}}, out);
  const auto j = test::run_reader("read_dream3d.py", {(out / "a.dream3d").string()});
  const auto& ensembles = j["matrices"]["CellEnsembleData"]["arrays"];
  // EbsdLib: 1 is cubic, 0 hexagonal, 5 monoclinic, 999 unknown
  EXPECT_EQ(ensembles["CrystalStructures"]["values"], (std::vector<int>{999, 1, 0, 5, 999}));
  EXPECT_EQ(ensembles["PhaseName"]["values"],
            (std::vector<std::string>{"Glass", "Iron", "Zinc", "Mica", "Air"}));
}

}  // namespace
}  // namespace terrazzo
