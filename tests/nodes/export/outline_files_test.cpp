// Outlines in files of other programs: what Export writes comes back through LoadLabels and LoadProfiles, and
// bad files are refused.
#include <gtest/gtest.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/random.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

constexpr const char* kNames[] = {"a.geojson", "a.coco.json", "a.zip"};

// Random blobs: parts, holes, and pixels that only touch at a corner.
Labels random_labels(int sections) {
  Labels out;
  out.width = 37;
  out.height = 23;
  out.sections = sections;
  out.pixel_size = 0.25;
  constexpr int kPerSection = 6;
  for (int i = 0; i < out.width * out.height * sections; ++i) {
    Random random(11, 0, i);
    const auto k = static_cast<std::int32_t>(random.below(kPerSection + 1));
    out.ids.push_back(k == 0 ? 0 : k + kPerSection * (i / (out.width * out.height)));
  }
  for (int k = 0; k < kPerSection * sections; ++k) out.classes.push_back(k % 3);
  return out;
}

class OutlineFiles : public ::testing::Test {
 protected:
  fs::path exported(const std::string& name, const std::multimap<std::string, Value>& inputs) {
    test::run_node("Export", inputs, {{"path", name}}, folder);
    return folder / name;
  }
  fs::path written(const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  static test::NodeRun load(const std::string& type, const fs::path& file, const Image* image = nullptr,
                            std::map<std::string, std::string> parameters = {}) {
    parameters["path"] = file.string();
    std::multimap<std::string, Value> inputs;
    if (image) inputs.emplace("image", Value::of(*image));
    return test::run_node(type, inputs, parameters);
  }
  // Code, parameter, and whether the message names the file.
  static std::string failure(const std::string& type, const fs::path& file, const Image* image = nullptr) {
    try {
      load(type, file, image);
    } catch (const Error& e) {
      const Diagnostic& d = e.diagnostic();
      return d.code + " " + d.parameter +
             (d.message.find(file.filename().string()) == std::string::npos ? " without file" : "");
    }
    return "";
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(OutlineFiles, LabelsComeBackPixelByPixel) {
  for (const int sections : {1, 2}) {
    const Labels labels = random_labels(sections);
    const Image image(labels.width, labels.height, sections, labels.pixel_size);
    for (const char* name : kNames) {
      const fs::path file = exported(name, {{"labels", Value::of(labels)}});
      const Labels back = load("LoadLabels", file, &image).output<Labels>("labels");
      EXPECT_EQ(back.ids, labels.ids) << name;
      EXPECT_EQ(back.classes, labels.classes) << name;
      EXPECT_EQ(back.pixel_size, 0.25) << name;
      EXPECT_EQ(back.sections, sections) << name;
      if (std::string(name) == "a.zip") continue;  // ImageJ's regions do not know their picture
      const Labels alone = load("LoadLabels", file).output<Labels>("labels");
      EXPECT_EQ(alone.ids, labels.ids) << name;
      EXPECT_EQ(alone.pixel_size, 0.25) << name;
    }
  }
  const Labels again = random_labels(1);
  const std::string first = test::content_of(exported("a.zip", {{"labels", Value::of(again)}}));
  EXPECT_EQ(test::content_of(exported("b.zip", {{"labels", Value::of(again)}})), first);
}

TEST_F(OutlineFiles, ProfilesComeBackWithTheirContours) {
  const Image image(40, 30, 1, 0.5);
  Profiles given;
  given.window = Vec2(20, 15);
  given.observed_area = 300;
  given.classes = 2;
  for (const Vec2& at : {Vec2(4.1, 5.2), Vec2(14.3, 8.9), Vec2(1, 11.9)}) {
    Profile p;
    p.cls = count_of(given.profiles) % 2;
    p.centroid = at;
    for (int k = 0; k < 12; ++k)
      p.contour.push_back(at +
                          Vec2(1.1 * std::cos(k * 0.5235987755982988), std::sin(k * 0.5235987755982988)));
    p.area = 3.3;  // 12-gon of half axes 1.1 and 1
    given.profiles.push_back(p);
  }
  for (const char* name : kNames) {
    const fs::path file = exported(name, {{"profiles", Value::of(given)}, {"image", Value::of(image)}});
    const auto back = load("LoadProfiles", file, &image).output<Profiles>("profiles");
    ASSERT_EQ(back.profiles.size(), 3u) << name;
    EXPECT_EQ(back.window, given.window) << name;
    EXPECT_EQ(back.observed_area, 300) << name;
    EXPECT_NEAR(back.area_fraction, 9.9 / 300, 1e-6) << name;
    for (int k = 0; k < 3; ++k) {
      const Profile &p = back.profiles[k], &q = given.profiles[k];
      EXPECT_EQ(p.cls, q.cls) << name;
      EXPECT_NEAR(p.area, q.area, 1e-5) << name;
      EXPECT_LT((p.centroid - q.centroid).norm(), 1e-5) << name;
      ASSERT_EQ(p.contour.size(), q.contour.size()) << name;
      for (const Vec2& point : p.contour) {
        double nearest = 1;
        for (const Vec2& other : q.contour) nearest = std::min(nearest, (point - other).norm());
        EXPECT_LT(nearest, 1e-5) << name;
      }
    }
    // A box of 2.2 × 2 mm has 17.8 × 13 mm² of places in 20 × 15 mm².
    EXPECT_NEAR(back.profiles[0].weight, 300 / (17.8 * 13), 1e-5) << name;
    EXPECT_TRUE(back.profiles[2].touches_border) << name;
    EXPECT_EQ(back.profiles[2].weight, 0) << name;
  }
  EXPECT_EQ(load("LoadProfiles", folder / "a.geojson", nullptr, {{"pixel_size", "1"}})
                .output<Profiles>("profiles")
                .observed_area,
            1200);
  const auto bare = load("LoadProfiles", folder / "a.zip");
  EXPECT_EQ(bare.output<Profiles>("profiles").observed_area, 0);
  EXPECT_EQ(bare.warnings.size(), 1u);
}

TEST_F(OutlineFiles, TablesHavePixelsAndColorsBesideTheirPicture) {
  Profiles p;
  p.window = Vec2(20, 15);
  p.profiles.resize(2);
  p.profiles[0].contour = {{2, 2}, {6, 2}, {6, 5}, {2, 5}};
  for (Profile& q : p.profiles) q.area = 12;
  const Image image(40, 30, 1, 0.5, Vec3f(0.25f, 0.5f, 1));
  const std::string text =
      test::content_of(exported("a.csv", {{"profiles", Value::of(p)}, {"image", Value::of(image)}}));
  EXPECT_NE(text.find(",area_px,equivalent_diameter_px,perimeter_px,major_axis_px,"), std::string::npos)
      << text;
  EXPECT_NE(text.find(",14,"), std::string::npos) << text;  // perimeter
  EXPECT_NE(text.find(",48,"), std::string::npos) << text;  // pixels
  EXPECT_NE(text.find(",0.25,0.5,1\n"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with(",,,\n")) << text;  // no outline, no measures
  const auto back = load("LoadProfiles", folder / "a.csv");
  EXPECT_EQ(back.output<Profiles>("profiles").profiles[0].area, 12);
  EXPECT_TRUE(back.warnings.empty());
}

TEST_F(OutlineFiles, WhatDoesNotFitIsRefused) {
  const auto code = [&](const std::string& name, const std::multimap<std::string, Value>& inputs) {
    try {
      exported(name, inputs);
    } catch (const Error& e) {
      EXPECT_FALSE(fs::exists(folder / name));
      return e.diagnostic().code;
    }
    return std::string();
  };
  Profiles p;
  p.profiles.resize(1);
  p.profiles[0].contour = {{2, 2}, {6, 2}, {6, 5}};
  const Value profiles = Value::of(p), image = Value::of(Image(40, 30, 1, 0.5));
  EXPECT_EQ(code("a.geojson", {{"profiles", profiles}}), "missing-input");
  p.window = Vec2(1, 1);
  EXPECT_EQ(code("a.geojson", {{"profiles", Value::of(p)}, {"image", image}}), "size-mismatch");
  EXPECT_EQ(code("a.geojson", {{"image", image}}), "format-does-not-fit");
  EXPECT_EQ(code("a.roi", {{"labels", Value::of(random_labels(1))}}), "format-does-not-fit");
  p.profiles[0].contour = {{-30000, 0}, {1, 0}, {1, 1}};
  p.window = Vec2::Zero();
  EXPECT_EQ(code("a.roi", {{"profiles", Value::of(p)}, {"image", image}}), "format-does-not-fit");
  p.profiles[0].contour.clear();
  EXPECT_EQ(code("a.zip", {{"profiles", Value::of(p)}, {"image", image}}), "no-outlines");
}

std::string geojson(const std::string& polygons) {
  std::string features;
  std::istringstream in(polygons);
  for (std::string rings; std::getline(in, rings, ';');)
    features += std::string(features.empty() ? "" : ",") +
                R"({"type":"Feature","geometry":{"type":"Polygon","coordinates":[)" + rings + "]}}";
  return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

TEST_F(OutlineFiles, BadOutlinesAreNamed) {
  const Image image(10, 10, 1, 1);
  const auto refused = [&](const std::string& text) {
    const std::string labels = failure("LoadLabels", written("bad.geojson", text), &image);
    EXPECT_EQ(failure("LoadProfiles", folder / "bad.geojson", &image), labels);
    return labels;
  };
  const std::string square = "[[1,1],[4,1],[4,4],[1,4],[1,1]]";
  EXPECT_EQ(refused(geojson(square)), "");
  EXPECT_EQ(refused(geojson("[[1,1],[4,4],[4,1],[1,4],[1,1]]")), "bad-outline path");  // crosses itself
  EXPECT_EQ(refused(geojson(square + ";[[3,3],[6,3],[6,6],[3,6],[3,3]]")), "bad-outline path");  // overlaps
  EXPECT_EQ(refused(geojson(square + ";[[4,1],[6,1],[6,4],[4,4],[4,1]]")), "");                  // touches
  EXPECT_EQ(refused(geojson("[[1,1],[12,1],[12,4],[1,1]]")), "bad-outline path");                // outside
  EXPECT_EQ(refused(geojson("[[1,1],[4,1],[7,1],[1,1]]")), "bad-outline path");                  // no area
  EXPECT_EQ(refused(geojson("[[1,1],[4,1]]")), "bad-outline path");
  EXPECT_EQ(refused(R"({"type":"FeatureCollection","features":[]})").substr(0, 5), "no-pa");
  EXPECT_EQ(failure("LoadLabels", written("a.geojson", geojson(square))), "missing-input path");
  EXPECT_EQ(failure("LoadLabels", written("a.json", R"({"type": "Point", "coordinates": [1, 2]})"), &image),
            "unreadable-outlines path");

  const std::string coco = R"({"images":[{"id":1,"width":10,"height":10}],"annotations":[{"image_id":1,)";
  const auto with = [&](const std::string& segmentation) {
    return failure("LoadLabels", written("a.json", coco + R"("segmentation":)" + segmentation + "}]}"));
  };
  EXPECT_EQ(with("[[1,1,4,1,4,4]]"), "");
  EXPECT_EQ(with("[[1,1,4,1,4]]"), "bad-outline path");
  EXPECT_EQ(with(R"({"size":[10,10],"counts":[5,20,75]})"), "");
  EXPECT_EQ(with(R"({"size":[10,10],"counts":[5,200]})"), "bad-outline path");
  EXPECT_EQ(with(R"({"size":[10,10],"counts":"~~~"})"), "bad-outline path");
  const Image other(11, 10, 1, 1);
  EXPECT_EQ(failure("LoadLabels", written("a.json", coco + R"("segmentation":[[1,1,4,1,4,4]]}]})"), &other),
            "size-mismatch path");
  EXPECT_EQ(failure("LoadProfiles", folder / "a.json", &other), "size-mismatch path");
  EXPECT_EQ(with(R"({"size":[8,10],"counts":[5,20,55]})"), "size-mismatch path");
  EXPECT_EQ(with(R"({"size":[10,10],"counts":[5.5,20,74.5]})"), "bad-outline path");
  const std::string scales = R"({"images":[{"id":1,"width":10,"height":10,"pixel_size_mm":1},)"
                             R"({"id":2,"width":10,"height":10,"pixel_size_mm":2}],"annotations":[)"
                             R"({"image_id":1,"segmentation":[[1,1,4,1,4,4]]}]})";
  EXPECT_EQ(failure("LoadLabels", written("a.json", scales)), "size-mismatch path");
  for (const char* scale : {"1", "2"})
    written(std::string("scale_") + scale + ".geojson",
            R"({"picture":{"width":10,"height":10,"pixel_size_mm":)" + std::string(scale) + "}," +
                geojson(square).substr(1));
  EXPECT_EQ(failure("LoadLabels", folder / "scale_2.geojson"), "");
  EXPECT_EQ(test::code_of([&] { load("LoadLabels", folder / "scale_*.geojson"); }), "size-mismatch");
}

TEST_F(OutlineFiles, CrossingsAtCornersAndHugeCoordinatesAreRefused) {
  const auto code = [&](const std::string& rings) {
    return failure("LoadProfiles", written("a.geojson", geojson(rings)));
  };
  EXPECT_EQ(code("[[0,6],[5,11],[15,21],[15,1],[5,11],[0,16],[0,6]]"), "bad-outline path");
  EXPECT_EQ(code("[[0,0],[10,10],[10,0],[5,5],[0,10],[0,0]]"), "bad-outline path");  // a corner on a side
  EXPECT_EQ(code("[[0,0],[5,5],[10,0],[10,10],[5,5],[0,10],[0,0]]"), "");            // only touches itself
  EXPECT_EQ(code("[[-9e307,0.5],[0,0.6],[9e307,0.6],[-9e307,0.5]]"), "bad-outline path");
  EXPECT_EQ(code("[[-9e307,0.5],[0,0.6],[9e307,0.6],[9e307,0.7],[-9e307,0.5]]"), "bad-outline path");
  EXPECT_EQ(code("[[-4,1],[4,1],[4,4],[-4,1]]"), "bad-outline path");
  EXPECT_EQ(code("[[0,0],[9,0],[9,9],[0,9],[0,0]],[[0,0],[9,0],[9,9],[0,9],[0,0]]"), "bad-outline path");
}

// Parts that share a side, a hole, and a part in the hole; fine outlines between the centers of pixels.
TEST_F(OutlineFiles, AreasAreExact) {
  const auto area = [&](const std::string& rings) {
    const auto run = load("LoadProfiles", written("a.geojson", geojson(rings)));
    return run.output<Profiles>("profiles").profiles.at(0);
  };
  const std::string left = "[[4,0],[4,4],[0,4],[0,0],[4,0]]";
  const Profile both = area(left + ",[[4,0],[8,0],[8,4],[4,4],[4,0]]");
  EXPECT_EQ(both.area, 32);
  EXPECT_EQ(both.centroid, Vec2(4, 2));
  EXPECT_EQ(area(left + ",[[4,1],[4,3],[2,3],[2,1],[4,1]]").area, 12);  // a hole that shares a side
  EXPECT_EQ(area(left + ",[[1,1],[3,1],[3,3],[1,3],[1,1]],[[1,1],[2,1],[2,2],[1,2],[1,1]]").area, 13);
  EXPECT_NEAR(area("[[1.6,1.6],[1.9,1.6],[1.9,1.9],[1.6,1.9],[1.6,1.6]]").area, 0.09, 1e-12);
}

TEST_F(OutlineFiles, ThePictureGivesSectionsAndColors) {
  const Image stack(10, 10, 10, 0.5, Vec3f(0.25f, 0.5f, 1));
  const std::string square = "[[1,1],[4,1],[4,4],[1,4],[1,1]]";
  const fs::path file = written("a.geojson", geojson(square));
  const auto back = load("LoadProfiles", file, &stack).output<Profiles>("profiles");
  EXPECT_EQ(back.sections, 10);
  EXPECT_EQ(back.observed_area, 250);
  EXPECT_EQ(back.profiles[0].color, Vec3f(0.25f, 0.5f, 1));
  EXPECT_EQ(load("LoadLabels", file, &stack).output<Labels>("labels").sections, 10);
  EXPECT_EQ(test::code_of([&] { load("LoadProfiles", file, nullptr, {{"unit", "µm"}}); }), "bad-value");
  const auto property = [&](const std::string& text, const Image* image = nullptr) {
    std::string json = geojson(square);
    json.insert(json.find(R"("geometry")"), R"("properties":{)" + text + "},");
    return failure("LoadProfiles", written("a.geojson", json), image);
  };
  const Image one(10, 10, 1, 1);
  EXPECT_EQ(property(R"("section":1,"class":3,"confidence":0.5)", &stack), "");
  EXPECT_EQ(property(R"("section":1)", &one), "size-mismatch path");
  for (const char* wrong : {R"("section":-1)", R"("section":1000000)", R"("class":0.5)", R"("class":2000000)",
                            R"("confidence":95)"})
    EXPECT_EQ(property(wrong), "bad-outline path") << wrong;
}

TEST_F(OutlineFiles, DamagedRegionsAreNamed) {
  Labels labels = random_labels(1);
  for (auto& id : labels.ids) id = id == 1;
  labels.classes.resize(1);
  const Image image(labels.width, labels.height, 1, 1), small(5, 5, 1, 1);
  const std::string roi = test::content_of(exported("a.roi", {{"labels", Value::of(labels)}}));
  EXPECT_EQ(load("LoadLabels", folder / "a.roi", &image).output<Labels>("labels").ids, labels.ids);
  EXPECT_EQ(failure("LoadLabels", folder / "a.roi", &small), "bad-outline path");  // of another picture
  for (std::size_t length = 4; length < roi.size() - 64; length += 13)
    EXPECT_EQ(failure("LoadLabels", written("cut.roi", roi.substr(0, length)), &image),
              "unreadable-outlines path")
        << length;
  std::string line = roi;
  line[6] = 3;
  EXPECT_EQ(failure("LoadLabels", written("line.roi", line), &image), "bad-outline path");
  const std::string zip = test::content_of(exported("a.zip", {{"labels", Value::of(labels)}}));
  EXPECT_EQ(failure("LoadLabels", written("cut.zip", zip.substr(0, zip.size() / 2)), &image),
            "unreadable-outlines path");
}

}  // namespace
}  // namespace terrazzo
