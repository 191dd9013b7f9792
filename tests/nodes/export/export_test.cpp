#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>

#include "nodes/common/io/image_file.h"
#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/data/volume.h"
#include "nodes/export/formats.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/picture_file.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;
using test::run_node;

using Inputs = std::multimap<std::string, Value>;

std::string failure(const Inputs& inputs, const std::string& path, const fs::path& folder) {
  return test::code_of([&] { run_node("Export", inputs, {{"path", path}}, folder); });
}

TEST(Export, EveryFormatHasAWriterAndAnExtensionOfItsOwn) {
  std::set<std::string> extensions;
  for (const Format& f : formats()) {
    EXPECT_TRUE(f.write) << f.extension;
    EXPECT_TRUE(extensions.insert(f.extension).second) << f.extension;
    EXPECT_EQ(&format_of("folder/name" + f.extension), &f);
  }
}

Table some_table() {
  Table t;
  t.columns = {"name", "area mm²", "odd, \"name\""};
  t.rows = {{std::string("a,b"), 0.1, 1.0 / 3},
            {std::string("say \"x\"\nnow"), -0.0, 1e300},
            {std::string(), 5e-324, 2.0}};
  return t;
}

Volume some_volume() {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(8, 8, 8);
  auto density = openvdb::FloatGrid::create(0);
  auto id = openvdb::Int32Grid::create(-1);
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  for (int i = 0; i < 8; ++i) {
    density->tree().setValue(openvdb::Coord(i, 0, 7), 0.125f * float(i));
    id->tree().setValue(openvdb::Coord(i, i, i), i);
    color->tree().setValue(openvdb::Coord(7, i, 0), openvdb::Vec3s(0.1f, 0.2f * float(i), 3));
  }
  density->setName("density");
  id->setName("id");
  color->setName("Cd");
  for (const openvdb::GridBase::Ptr& g :
       {openvdb::GridBase::Ptr(density), openvdb::GridBase::Ptr(id), openvdb::GridBase::Ptr(color)}) {
    g->setTransform(voxel_transform(0.25));
    v.grids.push_back(g);
  }
  return v;
}

Image some_image(int sections) {
  Image image(5, 4, sections, 1);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = Vec3f(float(i % 7) / 7, float(i % 3) / 3, float(i % 11) / 11);
  return image;
}

Labels some_labels(std::int32_t largest) {
  Labels l;
  l.width = 6;
  l.height = 5;
  l.sections = 2;
  l.ids.assign(60, 0);
  l.ids[0] = 1;
  l.ids[29] = 300;
  l.ids[30] = largest;
  l.classes.assign(static_cast<std::size_t>(largest), 0);
  return l;
}

TEST(ExportCsv, NumbersReadBackAsTheSameNumbers) {
  Particles p = test::some_particles(50);
  p.voids.assign(50, 0);
  p.voids[3] = 1;
  std::istringstream lines(csv_of(p));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "id,shape,class,x,y,z,qw,qx,qy,qz,scale,size,color_r,color_g,color_b,void");
  for (std::size_t i = 0; i < p.count(); ++i) {
    ASSERT_TRUE(std::getline(lines, line));
    std::vector<double> cell;
    std::istringstream cells(line);
    for (std::string c; std::getline(cells, c, ',');) cell.push_back(std::stod(c));
    ASSERT_EQ(cell.size(), 16u);
    EXPECT_EQ(cell[0], double(i));
    EXPECT_EQ(cell[1], p.shape[i]);
    EXPECT_EQ(Vec3(cell[3], cell[4], cell[5]), p.position[i]);
    EXPECT_EQ(cell[6], p.orientation[i].w());
    EXPECT_EQ(cell[10], p.scale[i]);
    EXPECT_EQ(static_cast<float>(cell[14]), p.color[i].z());
    EXPECT_EQ(cell[15], i == 3);
  }
  EXPECT_FALSE(std::getline(lines, line));

  const Shapes shapes = test::two_shapes();
  const auto folder = test::temporary_folder();
  test::run_node("Export", {{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}}, {{"path", "p.csv"}},
                 folder);
  std::istringstream wide(test::content_of(folder / "p.csv"));
  std::getline(wide, line);
  EXPECT_TRUE(line.ends_with(",void,equivalent_diameter")) << line;
  std::getline(wide, line);
  EXPECT_NEAR(std::stod(line.substr(line.rfind(',') + 1)),
              p.scale[0] * std::cbrt(6 / std::numbers::pi * shapes.shapes[p.shape[0]].volume), 1e-12);
}

TEST(ExportCsv, WordsAreQuotedWhereTheyMustBe) {
  EXPECT_EQ(csv_of(some_table()),
            "name,area mm²,\"odd, \"\"name\"\"\"\n\"a,b\",0.1,0.3333333333333333\n"
            "\"say \"\"x\"\"\nnow\",-0,1e+300\n,5e-324,2\n");
}

TEST(ExportCsv, DistributionsAndMatricesAsColumns) {
  SizeDistribution d;
  d.class_edges = {0, 1, 2.5};
  d.shapes = {{0, 0, {3, 4}, {2, 3}, {5, 6}}, {1, 2, {0.5, 0}, {0, 0}, {1, 0}}};
  EXPECT_EQ(csv_of(d),
            "shape,class,size_low,size_high,N_V,low,high\n0,0,0,1,3,2,5\n0,0,1,2.5,4,3,6\n"
            "1,2,0,1,0.5,0,1\n1,2,1,2.5,0,0,0\n");
  KMatrix k;
  k.classes = 2;
  k.shapes.resize(1);
  k.shapes[0].K = (Eigen::MatrixXd(2, 2) << 0.5, 0.25, 0, 0.75).finished();
  EXPECT_EQ(csv_of(k), "shape,profile_class,size_1,size_2\n0,1,0.5,0.25\n0,2,0,0.75\n");
}

TEST(Export, JsonIsTheValuesDescription) {
  const fs::path out = test::temporary_folder();
  const Value particles = Value::of(test::some_particles(4)), table = Value::of(some_table());
  run_node("Export", {{"particles", particles}}, {{"path", "deep/er/p.json"}}, out);
  EXPECT_EQ(nlohmann::json::parse(test::content_of(out / "deep/er/p.json")),
            particles.type().describe(particles.data()));
  run_node("Export", {{"particles", particles}, {"table", table}}, {{"path", "both.json"}}, out);
  const auto both = nlohmann::json::parse(test::content_of(out / "both.json"));
  EXPECT_EQ(both.at("table"), table.type().describe(table.data()));
  EXPECT_EQ(both.at("particles").at("scale").size(), 4u);
}

TEST(Export, TheUntypedInputTakesAnything) {
  const fs::path out = test::temporary_folder();
  run_node("Export", {{"value", Value::of(some_table())}}, {{"path", "t.csv"}}, out);
  EXPECT_EQ(test::content_of(out / "t.csv"), csv_of(some_table()));
  run_node("Export",
           {{"value", Value::of(test::some_particles(3))}, {"shapes", Value::of(test::two_shapes())}},
           {{"path", "p.glb"}}, out);
  EXPECT_EQ(test::content_of(out / "p.glb").substr(0, 4), "glTF");
}

TEST(Export, VolumesComeBackFromVdb) {
  const fs::path out = test::temporary_folder();
  const Volume v = some_volume();
  run_node("Export", {{"volume", Value::of(v)}}, {{"path", "v.vdb"}, {"id_type", "int32"}}, out);
  openvdb::io::File file((out / "v.vdb").string());
  file.open();
  EXPECT_EQ(file.getMetadata()->metaValue<std::string>("creator"), "Terrazzo");
  EXPECT_EQ(file.getMetadata()->metaValue<openvdb::Vec3i>("period"), openvdb::Vec3i(8, 8, 8));
  EXPECT_NO_THROW(nlohmann::json::parse(file.getMetadata()->metaValue<std::string>("provenance")));
  ASSERT_EQ(file.getGrids()->size(), 3u);
  const auto id = openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("id"));
  const auto color = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("Cd"));
  ASSERT_TRUE(id && color);
  EXPECT_EQ(id->background(), -1);
  EXPECT_EQ(id->activeVoxelCount(), 8u);
  EXPECT_EQ(id->transform(), *voxel_transform(0.25));
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(id->tree().getValue(openvdb::Coord(i, i, i)), i);
    EXPECT_EQ(color->tree().getValue(openvdb::Coord(7, i, 0)), openvdb::Vec3s(0.1f, 0.2f * float(i), 3));
  }
}

TEST(Export, PicturesComeBack) {
  const fs::path out = test::temporary_folder();
  const Image image = some_image(1);
  for (const auto& [name, tolerance] :
       {std::pair{"a.png", 0.008}, {"a.tif", 2e-5}, {"a.exr", 0.0}, {"a.hdr", 0.01}}) {
    run_node("Export", {{"image", Value::of(image)}}, {{"path", name}}, out);
    const Image back = read_image(out / name);
    ASSERT_EQ(back.pixels.size(), image.pixels.size()) << name;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      ASSERT_LE((back.pixels[i] - image.pixels[i]).cwiseAbs().maxCoeff(), tolerance + 1e-7)
          << name << " " << i;
  }
}

TEST(Export, AStackBecomesNumberedFiles) {
  const fs::path out = test::temporary_folder();
  const Image image = some_image(3);
  run_node("Export", {{"image", Value::of(image)}}, {{"path", "sub/cut.exr"}}, out);
  EXPECT_EQ(test::files_in(out / "sub"), 3u);
  EXPECT_EQ(read_image(out / "sub/cut_002.exr").at(3, 1), image.at(3, 1, 2));
  EXPECT_EQ(section_name("a/b.png", 12, 5000), "a/b_0012.png");
}

TEST(Export, LabelsAreExactIntegers) {
  const fs::path out = test::temporary_folder();
  for (const auto& [name, largest] : {std::pair{"l.png", 65535}, {"l.tif", 70001}, {"l.exr", 16777217}}) {
    Labels labels = some_labels(65535);
    labels.ids[30] = largest;
    run_node("Export", {{"labels", Value::of(labels)}}, {{"path", name}}, out);
    std::string second = name;
    second.insert(1, "_001");
    const auto in = picture_codec().open(out / second, "", {});
    EXPECT_EQ(in->header().count(), 1);
    std::vector<std::uint32_t> ids(30);
    if (in->header().sample == Sample::UInt16) {  // a conversion would scale the values
      std::vector<std::uint16_t> narrow(30);
      ASSERT_TRUE(in->read(Sample::UInt16, narrow.data()));
      ids.assign(narrow.begin(), narrow.end());
    } else {
      ASSERT_EQ(in->header().sample, Sample::UInt32) << name;
      ASSERT_TRUE(in->read(Sample::UInt32, ids.data()));
    }
    EXPECT_EQ(ids[0], static_cast<std::uint32_t>(largest)) << name;
    EXPECT_EQ(ids[1], 0u);
  }
  Labels labels = some_labels(65535);
  labels.ids[30] = 65536;
  EXPECT_EQ(failure({{"labels", Value::of(labels)}}, "m.png", out), "too-many-labels");
  EXPECT_FALSE(fs::exists(out / "m_001.png"));
}

TEST(Export, MeshesForOtherPrograms) {
  const fs::path out = test::temporary_folder();
  Shapes one;
  one.shapes = {test::tetrahedron("t", false)};
  run_node("Export", {{"shapes", Value::of(test::two_shapes())}}, {{"path", "s.obj"}}, out);
  const std::string obj = test::content_of(out / "s.obj");
  EXPECT_NE(obj.find("o smooth\nv 1 1 1\n"), std::string::npos);
  EXPECT_NE(obj.find("f 9 10 11\n"), std::string::npos);  // the third shape's first triangle
  run_node("Export", {{"shapes", Value::of(one)}}, {{"path", "s.stl"}}, out);
  EXPECT_EQ(fs::file_size(out / "s.stl"), 84u + 4 * 50);
  run_node("Export", {{"shapes", Value::of(one)}}, {{"path", "s.ply"}}, out);
  const std::string ply = test::content_of(out / "s.ply");
  EXPECT_EQ(ply.size() - ply.find("end_header\n") - 11, 4u * 24 + 4 * 13);
  EXPECT_EQ(failure({{"shapes", Value::of(test::two_shapes())}}, "two.stl", out), "one-shape-only");
}

TEST(Export, SaysWhatDoesNotFit) {
  const fs::path out = test::temporary_folder();
  const Value table = Value::of(some_table()), particles = Value::of(test::some_particles(3)),
              image = Value::of(some_image(1)), shapes = Value::of(test::two_shapes());
  EXPECT_EQ(failure({}, "a.csv", out), "no-input");
  EXPECT_EQ(failure({{"table", table}}, "a.docx", out), "unknown-format");
  EXPECT_EQ(failure({{"table", table}}, "a", out), "unknown-format");
  EXPECT_EQ(failure({{"table", table}}, "a.png", out), "format-does-not-fit");
  EXPECT_EQ(failure({{"image", image}}, "a.vdb", out), "format-does-not-fit");
  EXPECT_EQ(failure({{"labels", Value::of(some_labels(5))}}, "a.jpg", out), "format-does-not-fit");
  EXPECT_EQ(failure({{"table", table}, {"particles", particles}}, "a.csv", out), "format-does-not-fit");
  EXPECT_EQ(failure({{"particles", particles}}, "a.glb", out), "no-shapes");
  EXPECT_EQ(failure({{"particles", particles}, {"shapes", shapes}, {"table", table}}, "a.glb", out),
            "format-does-not-fit");
  EXPECT_EQ(failure({{"table", table}, {"value", table}}, "a.csv", out), "two-inputs");
  EXPECT_EQ(failure({{"volume", Value::of(Volume())}}, "a.vdb", out), "no-grids");
  EXPECT_EQ(test::files_in(out), 0u);
}

TEST(Export, AFullDiskLeavesNothingUnderTheFinalName) {
  const fs::path out = test::temporary_folder();
  Image big(300, 300, 1, 1);
  for (std::size_t i = 0; i < big.pixels.size(); ++i) {
    Random r(1, 1, i);
    big.pixels[i] = Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform()));
  }
  Labels labels;
  labels.width = labels.height = 300;
  labels.classes.assign(60000, 0);
  for (std::size_t i = 0; i < 90000; ++i)
    labels.ids.push_back(static_cast<std::int32_t>(Random(2, 2, i).below(60000)));
  Volume volume = some_volume();
  auto noise = openvdb::FloatGrid::create(0);
  noise->setName("noise");
  for (int i = 0; i < 32768; ++i)
    noise->tree().setValue(openvdb::Coord(i % 32, i / 32 % 32, i / 1024), float(Random(3, 3, i).uniform()));
  volume.grids.push_back(noise);
  Table table;
  table.columns = {"x"};
  table.rows.assign(20000, {1.0 / 3});
  const Value picture = Value::of(big), shapes = Value::of(test::two_shapes());
  const std::vector<std::pair<std::string, Inputs>> cases = {
      {"a.png", {{"image", picture}}},
      {"a.jpg", {{"image", picture}}},
      {"a.tif", {{"image", picture}}},
      {"a.exr", {{"image", picture}}},
      {"a.hdr", {{"image", picture}}},
      {"l.png", {{"labels", Value::of(labels)}}},
      {"l.tif", {{"labels", Value::of(labels)}}},
      {"v.vdb", {{"volume", Value::of(volume)}}},
      {"p.glb", {{"particles", Value::of(test::some_particles(2000))}, {"shapes", shapes}}},
      {"t.csv", {{"table", Value::of(table)}}},
      {"t.json", {{"table", Value::of(table)}}},
  };
  for (const auto& [path, inputs] : cases) {
    {
      const test::FullDisk full(40000);
      EXPECT_EQ(failure(inputs, path, out), "write-failed") << path;
    }
    EXPECT_EQ(test::files_in(out), 0u) << path;
    EXPECT_EQ(failure(inputs, path, out), "") << path << " with enough space";
    EXPECT_GT(fs::file_size(out / path), 40000u) << path;
    fs::remove(out / path);
  }
}

TEST(Export, AnUnwritableFolderIsAnError) {
  const fs::path out = test::temporary_folder();
  std::ofstream(out / "file") << "in the way";
  EXPECT_EQ(failure({{"table", Value::of(some_table())}}, "file/t.csv", out), "write-failed");
  EXPECT_EQ(failure({{"table", Value::of(some_table())}}, "t.csv", "/proc"), "write-failed");
}

TEST(Export, AFailureKeepsTheFileThatWasThere) {
  const fs::path out = test::temporary_folder();
  run_node("Export", {{"table", Value::of(some_table())}}, {{"path", "t.csv"}}, out);
  const std::string before = test::content_of(out / "t.csv");
  Table other;
  other.columns = {"x"};
  other.rows.assign(20000, {1.0 / 3});
  {
    const test::FullDisk full(1000);
    EXPECT_EQ(failure({{"table", Value::of(other)}}, "t.csv", out), "write-failed");
  }
  EXPECT_EQ(test::content_of(out / "t.csv"), before);
}

}  // namespace
}  // namespace terrazzo
