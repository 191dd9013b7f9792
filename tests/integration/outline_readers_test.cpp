// Outlines that other programs read, and theirs: Python's json and zipfile, shapely, scikit-image, tifffile.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/random.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using nlohmann::json;

class OutlineReaders : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* module : {"shapely", "skimage", "tifffile"})
      if (!test::has_python_module(module)) GTEST_SKIP() << "python3-" << module << " is not installed";
  }
  std::filesystem::path folder = test::temporary_folder();
};

TEST_F(OutlineReaders, ReadEveryPixelOfExportedLabels) {
  Labels labels;
  labels.width = 31;
  labels.height = 17;
  labels.sections = 2;
  for (int i = 0; i < labels.width * labels.height * labels.sections; ++i) {
    const auto k = static_cast<std::int32_t>(Random(3, 0, i).below(5));
    labels.ids.push_back(k == 0 ? 0 : k + 4 * (i / (labels.width * labels.height)));
  }
  for (int k = 0; k < 8; ++k) labels.classes.push_back(k % 2);
  for (const char* name : {"a.geojson", "a.coco.json", "a.zip"}) {
    test::run_node("Export", {{"labels", Value::of(labels)}}, {{"path", name}}, folder);
    const json read = test::run_reader("read_outlines.py", {(folder / name).string(), "31", "17"});
    ASSERT_TRUE(read.is_object()) << name;
    EXPECT_EQ(read["labels"].get<std::vector<std::int32_t>>(), labels.ids) << name;
    EXPECT_EQ(read["classes"].get<std::vector<std::int32_t>>(), labels.classes) << name;
    EXPECT_TRUE(read["valid"].get<bool>()) << name;
    EXPECT_TRUE(read["wound"].get<bool>()) << name;
  }
}

TEST_F(OutlineReaders, WriteWhatLoadLabelsReads) {
  const json made = test::run_reader("write_outlines.py", {folder.string()});
  ASSERT_TRUE(made.is_object());
  const Image image(60, 40, 1, 0.5), stack(60, 40, 2, 0.5);
  const auto load = [&](const std::string& name, const Image& picture) {
    return test::run_node("LoadLabels", {{"image", Value::of(picture)}}, {{"path", (folder / name).string()}})
        .output<Labels>("labels");
  };
  for (const char* name : {"qupath.geojson", "polygons.json", "runs.json", "packed.json", "set.zip"}) {
    const Labels labels = load(name, image);
    const std::string roi = std::string(name) == "set.zip" ? "roi_" : "";
    EXPECT_EQ(labels.ids, made[roi + "labels"].get<std::vector<std::int32_t>>()) << name;
    EXPECT_EQ(labels.classes, made[roi + "classes"].get<std::vector<std::int32_t>>()) << name;
  }
  EXPECT_EQ(load("star.roi", stack).sections, 2);
  // Label pictures of Cellpose (16 bit, or 32 from 65,536 cells on) and StarDist (32 bit).
  for (const char* name : {"uint8.tif", "uint16.tif", "uint32.tif", "int32.tif"}) {
    const Labels labels = load(name, image);
    EXPECT_EQ(labels.ids, made["labels"].get<std::vector<std::int32_t>>()) << name;
    test::run_node("Export", {{"labels", Value::of(labels)}}, {{"path", std::string("back_") + name}},
                   folder);
    const json back = test::run_reader("read_labels.py", {(folder / (std::string("back_") + name)).string()});
    EXPECT_EQ(back, made["labels"]) << name;
  }
}

// Gravel of barton_creek.jpg as segmenteverygrain outlined it: 1 is the inside of grains.
TEST_F(OutlineReaders, MeasureGrainsLikeExport) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "the shared data are absent";
  const auto run = [&](const char* type, const std::multimap<std::string, Value>& inputs,
                       std::map<std::string, std::string> parameters) {
    return test::run_node(type, inputs, parameters, folder);
  };
  const Value image =
      run("LoadImage", {}, {{"path", (data / "photos/barton_creek.jpg").string()}, {"pixel_size", "0.4"}})
          .outputs.at("image");
  Labels labels =
      run("LoadLabels", {}, {{"path", (data / "photos/barton_creek_mask.png").string()}, {"kind", "classes"}})
          .output<Labels>("labels");
  std::vector<std::int32_t> grain(labels.classes.size() + 1, 0);
  std::int32_t count = 0;
  for (std::size_t k = 0; k < labels.classes.size(); ++k)
    if (labels.classes[k] == 0) grain[k + 1] = ++count;
  for (std::int32_t& id : labels.ids) id = grain[id];
  labels.classes.assign(count, 0);
  labels.pixel_size = 0.4;
  const auto found = run("Segment", {{"image", image}, {"labels", Value::of(labels)}}, {{"view", "surface"}});
  run("Export", {{"labels", found.outputs.at("labels")}}, {{"path", "a.tif"}});
  run("Export", {{"profiles", found.outputs.at("profiles")}, {"image", image}}, {{"path", "a.csv"}});
  const json read =
      test::run_reader("measure_labels.py", {(folder / "a.tif").string(), (folder / "a.csv").string()});
  ASSERT_TRUE(read.is_object());
  EXPECT_GT(read["count"], 300);
  for (const char* name : {"major_axis_px", "minor_axis_px", "equivalent_diameter_px", "area_px"})
    EXPECT_LT(read[name], 0.01) << name;
  EXPECT_LT(read["orientation"], 1);
}

}  // namespace
}  // namespace terrazzo
