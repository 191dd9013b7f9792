#include <gtest/gtest.h>

#include "graph/diagnostic.h"
#include "nodes/data/labels.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::code_of;

template <class T>
std::string write(const std::filesystem::path& path, int w, int h, int channels, const std::vector<T>& data,
                  Sample type) {
  test::write_picture(path, w, h, channels, type, data);
  return path.string();
}

Labels load(const std::string& path, const std::string& kind) {
  return test::run_node("LoadLabels", {}, {{"path", path}, {"kind", kind}, {"pixel_size", "0.5"}})
      .output<Labels>("labels");
}

TEST(LoadLabels, InstancesKeepTheirOrder) {
  const auto folder = test::temporary_folder();
  const std::vector<std::uint16_t> data = {0, 700, 700, 3, 0, 40000};
  for (const char* name : {"a.png", "a.tif"}) {
    const Labels l = load(write(folder / name, 3, 2, 1, data, Sample::UInt16), "instances");
    EXPECT_EQ(l.ids, (std::vector<std::int32_t>{0, 2, 2, 1, 0, 3})) << name;
    EXPECT_EQ(l.count(), 3);
    EXPECT_EQ(l.pixel_size, 0.5);
  }
  const Labels wide =
      load(write(folder / "f.tif", 3, 1, 1, std::vector<float>{0, 70000, 2}, Sample::Float), "instances");
  EXPECT_EQ(wide.ids, (std::vector<std::int32_t>{0, 2, 1}));
}

TEST(LoadLabels, ClassesAreTheirConnectedComponents) {
  const auto folder = test::temporary_folder();
  const std::vector<std::uint8_t> data = {1, 0, 2,  //
                                          0, 1, 0,  //
                                          0, 0, 1,  //
                                          2, 0, 0};
  const Labels l = load(write(folder / "c.png", 3, 4, 1, data, Sample::UInt8), "classes");
  EXPECT_EQ(l.count(), 3);  // diagonal pixels are connected
  EXPECT_EQ(l.classes, (std::vector<std::int32_t>{0, 1, 1}));
  EXPECT_EQ(l.ids[0], l.ids[8]);
}

TEST(LoadLabels, ColorsAreClassesAndBlackIsBackground) {
  const auto folder = test::temporary_folder();
  const std::vector<std::uint8_t> data = {255, 0, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0};
  const Labels l = load(write(folder / "c.png", 4, 1, 3, data, Sample::UInt8), "classes");
  EXPECT_EQ(l.ids, (std::vector<std::int32_t>{1, 0, 2, 3}));
  EXPECT_EQ(l.classes, (std::vector<std::int32_t>{1, 0, 1}));
}

TEST(LoadLabels, StackNumbersThrough) {
  const auto folder = test::temporary_folder();
  write(folder / "s1.png", 2, 1, 1, std::vector<std::uint8_t>{5, 0}, Sample::UInt8);
  write(folder / "s2.png", 2, 1, 1, std::vector<std::uint8_t>{5, 6}, Sample::UInt8);
  const Labels l = load((folder / "s*.png").string(), "instances");
  EXPECT_EQ(l.sections, 2);
  EXPECT_EQ(l.ids, (std::vector<std::int32_t>{1, 0, 2, 3}));
}

TEST(LoadLabels, ASecondMaskHasTheClasses) {
  const auto folder = test::temporary_folder();
  const auto bytes = [&](const char* name, int w, const std::vector<std::uint8_t>& data) {
    return write(folder / name, w, static_cast<int>(data.size()) / w, 1, data, Sample::UInt8);
  };
  const auto with = [&](const std::string& path, const std::string& classes, const std::string& kind) {
    return test::run_node("LoadLabels", {}, {{"path", path}, {"classes", classes}, {"kind", kind}})
        .output<Labels>("labels");
  };
  const auto ids = bytes("i.png", 5, {7, 7, 7, 0, 2});
  // The profiles 2 and 7 have the classes 3 and 1; a pixel of 7 is background, and one has another class.
  const Labels l = with(ids, bytes("c.png", 5, {1, 1, 4, 9, 3}), "instances");
  EXPECT_EQ(l.ids, (std::vector<std::int32_t>{2, 2, 2, 0, 1}));
  EXPECT_EQ(l.classes, (std::vector<std::int32_t>{2, 0}));
  EXPECT_EQ(with(ids, bytes("b.png", 5, {0, 0, 4, 0, 3}), "instances").classes,
            (std::vector<std::int32_t>{2, 3}));
  EXPECT_EQ(code_of([&] { with(ids, bytes("n.png", 5, {1, 1, 1, 1, 0}), "instances"); }), "bad-labels");
  EXPECT_EQ(code_of([&] { with(ids, bytes("s.png", 4, {1, 1, 1, 1}), "instances"); }), "size-mismatch");
  EXPECT_EQ(code_of([&] { with(ids, ids, "classes"); }), "both-given");
  EXPECT_EQ(code_of([&] { with(ids, (folder / "missing.png").string(), "instances"); }), "no-file");
}

TEST(LoadLabels, Errors) {
  const auto folder = test::temporary_folder();
  const auto empty = write(folder / "e.png", 2, 1, 1, std::vector<std::uint8_t>{0, 0}, Sample::UInt8);
  EXPECT_EQ(code_of([&] { load(empty, "instances"); }), "no-particles");
  EXPECT_EQ(code_of([&] { load(empty, "classes"); }), "no-particles");
  const auto half = write(folder / "h.tif", 2, 1, 1, std::vector<float>{1, 0.5f}, Sample::Float);
  EXPECT_EQ(code_of([&] { load(half, "instances"); }), "bad-labels");
  const auto below = write(folder / "n.tif", 2, 1, 1, std::vector<float>{1, -1}, Sample::Float);
  EXPECT_EQ(code_of([&] { load(below, "instances"); }), "bad-labels");
  std::vector<std::uint8_t> many(100);
  for (int i = 0; i < 100; ++i) many[i] = static_cast<std::uint8_t>(i);
  const auto blurred = write(folder / "m.png", 10, 10, 1, many, Sample::UInt8);
  EXPECT_EQ(code_of([&] { load(blurred, "classes"); }), "too-many-classes");
  EXPECT_EQ(load(blurred, "instances").count(), 99);
  write(folder / "u1.png", 2, 1, 1, std::vector<std::uint8_t>{1, 0}, Sample::UInt8);
  write(folder / "u2.png", 1, 2, 1, std::vector<std::uint8_t>{1, 0}, Sample::UInt8);
  EXPECT_EQ(code_of([&] { load((folder / "u*.png").string(), "classes"); }), "size-mismatch");
}

TEST(LoadLabels, RealMasks) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto path = data / "photos/pebbles";
  EXPECT_EQ(load((path / "tile_1_labels.png").string(), "instances").count(), 124);
  EXPECT_EQ(load((path / "tile_5_labels.png").string(), "instances").count(), 168);
}

}  // namespace
}  // namespace terrazzo
