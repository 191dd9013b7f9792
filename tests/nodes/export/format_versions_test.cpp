// The files of every format are those that were recorded for this version of Export. Its version is part of
// the action key: if an exporter changes, it must rise, or files of the former form stay up to date in
// caches.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/data/labels.h"
#include "runtime/hash.h"
#include "tests/contract/contents.h"
#include "tests/nodes/export/voxel_files.h"
#include "tests/support/all_nodes.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {
using nlohmann::json;
namespace fs = std::filesystem;

// The hashes of all files that one export writes. .vdb files contain a random number.
json files_of(const std::string& name, const std::multimap<std::string, Value>& inputs,
              const std::map<std::string, std::string>& parameters = {}) {
  const fs::path folder = test::exported(name, inputs, parameters).parent_path();
  json out = json::object();
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() != ".vdb")
      out[entry.path().filename().string()] = hash_of(test::content_of(entry.path())).text();
  return out;
}

json all_files() {
  const Value volume = Value::of(test::formula_volume()), seven = Value::of(test::formula_particles());
  const Value particles = Value::of(test::some_particles(20)), shapes = Value::of(test::two_shapes());
  json out;
  for (const char* name : {"a.vti", "a.vtu", "a.dream3d", "a.inp", "a.tesr", "a.msh", "a.stl"})
    out[name] = files_of(name, {{"volume", volume}, {"particles", seven}});
  for (const char* name : {"a.npy", "a.nii", "a.nvdb"})
    out[name] = files_of(name, {{"volume", volume}}, {{"grids", "id"}});
  for (const char* name : {"a.glb", "a.usda", "a.xml", "a.pbrt", "a.lmp"})
    out[name] = files_of(name, {{"particles", particles}, {"shapes", shapes}});
  out["nodes.glb"] =
      files_of("nodes.glb", {{"particles", particles}, {"shapes", shapes}}, {{"instancing", "nodes"}});
  for (const char* name : {"cut.glb", "cut.usda", "cut.obj", "cut.ply", "cut.stl"})
    out[name] = files_of(name, {{"particles", particles}, {"shapes", shapes}}, {{"crossing", "cut"}});
  for (const char* name : {"a.dds", "a.ktx2"})
    out[name] = files_of(name, {{"volume", volume}}, {{"grids", "Cd"}});
  for (const char* name : {"b.usda", "b.xml", "b.pbrt"})
    out[name] = files_of(name, {{"particles", particles}, {"shapes", shapes}, {"volume", volume}});
  Labels labels{3, 2, 1, 0.5, {1, 1, 0, 2, 1, 1}, {0, 1}};
  for (const char* name : {"a.geojson", "a.coco.json", "a.zip"})
    out[name] = files_of(name, {{"labels", Value::of(labels)}});
  for (const char* name : {"a.obj", "a.csv", "a.json"}) out[name] = files_of(name, {{"shapes", shapes}});
  return out;
}

TEST(ExportFormats, AreThoseRecordedForItsVersion) {
  const fs::path file = test::source_folder() / "tests" / "nodes" / "export" / "format_versions.json";
  const int version = test::all_nodes().find("Export")->version;
  if (std::getenv("TERRAZZO_RECORD_FORMATS")) {
    std::ofstream(file)
        << json{{"machine", test::this_machine()}, {"version", version}, {"files", all_files()}}.dump(1)
        << '\n';
    GTEST_SKIP() << "recorded";
  }
  const json recorded = json::parse(test::content_of(file));
  const std::string renew =
      "record again: TERRAZZO_RECORD_FORMATS=1 terrazzo_tests --gtest_filter=ExportFormats.*";
  ASSERT_EQ(recorded.at("version"), version) << renew;
  if (recorded.at("machine") != test::this_machine())
    GTEST_SKIP() << "files were recorded on another kind of machine";
  const json now = all_files();
  for (const auto& [name, files] : now.items()) {
    ASSERT_TRUE(recorded.at("files").contains(name)) << name << " is new: " << renew;
    EXPECT_EQ(files, recorded.at("files").at(name))
        << "the format of " << name << " changed: raise the version of Export, then " << renew;
  }
}

}  // namespace
}  // namespace terrazzo
