// Strips with text at an edge, and text written into the picture.
#include "nodes/photograph/marks/captions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/data/profiles.h"
#include "nodes/photograph/marks/levels.h"
#include "nodes/photograph/marks/objects.h"
#include "tests/nodes/photograph/segment/drawn_caption.h"
#include "tests/nodes/photograph/segment/synthetic_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

Image gray_micrograph(int width, int height, std::uint64_t seed = 1) {
  Image image(width, height, 1, 0.5, test::gray_level(186));
  const auto discs = test::scatter(width, height, 24, 8, 24, seed);
  for (const auto& d : discs) test::draw(image, d, test::gray_level(66));
  Random random(seed, 3);
  for (auto& p : image.pixels)
    p = test::gray_level(static_cast<int>(std::lround(255 * linear_to_srgb(p)[0] + 2 * random.normal())));
  return image;
}

std::vector<cv::Rect> captions_of(const Image& image) { return find_captions(levels_of(image, 0)); }

TEST(Captions, AStripAtAnyEdgeIsFound) {
  const Image picture = gray_micrograph(260, 180);
  const cv::Rect strips[] = {{0, 180, 260, 30}, {0, 0, 30, 260}, {0, 0, 260, 30}, {180, 0, 30, 260}};
  int quarters = 0;
  for (const auto& [paper, ink] : {std::pair{0, 255}, {255, 0}, {30, 230}, {200, 0}}) {
    const Image image =
        test::turned(test::with_strip(picture, 30, test::gray_level(paper), test::gray_level(ink)), quarters);
    const auto found = captions_of(image);
    ASSERT_EQ(found.size(), 1u) << paper;
    EXPECT_EQ(found[0], strips[quarters++]) << paper;
  }
}

TEST(Captions, CompressionHidesNoStrip) {
  const Image picture = gray_micrograph(260, 180);
  for (const auto& [paper, ink] : {std::pair{0, 255}, {255, 0}}) {
    const auto found = captions_of(
        test::compressed(test::with_strip(picture, 40, test::gray_level(paper), test::gray_level(ink)), 3));
    ASSERT_EQ(found.size(), 1u) << paper;
    EXPECT_EQ((found[0] & cv::Rect(0, 180, 260, 40)), cv::Rect(0, 180, 260, 40));
    EXPECT_LE(found[0].area(), 260 * 42);
  }
}

TEST(Captions, ATableWithLinesAndCellsIsFound) {
  Image image = test::with_strip(gray_micrograph(600, 300), 60, test::gray_level(0), test::gray_level(255));
  Coverage lines(600, 360);
  for (const double x : {0.0, 150.0, 400.0, 598.0}) lines.rectangle(x, 300, x + 2, 360);
  lines.rectangle(0, 300, 600, 302);
  lines.rectangle(0, 358, 600, 360);
  lines.paint(image, test::gray_level(255));
  const auto found = captions_of(image);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], cv::Rect(0, 300, 600, 60));
}

TEST(Captions, TextInThePictureIsFound) {
  const Image picture = gray_micrograph(420, 300);
  for (const int ink : {0, 255}) {
    Image image = picture;
    Coverage text(420, 300);
    add_text(text, 250, 230, "20 um", 36);
    text.rectangle(245, 275, 385, 282);
    text.paint(image, test::gray_level(ink));
    const auto found = captions_of(image);
    ASSERT_EQ(found.size(), 1u) << ink;
    EXPECT_EQ((found[0] & cv::Rect(246, 240, 138, 42)), cv::Rect(246, 240, 138, 42)) << ink;
    EXPECT_LT(found[0].area(), 420 * 300 / 6);
  }
}

// Between the digit and the m of "5 µm" lies µ, which reaches below the line.
TEST(Captions, ASingleDigitBesideABarIsFound) {
  Image image = gray_micrograph(420, 300);
  Coverage text(420, 300);
  add_text(text, 290, 230, "5 µm", 36);
  text.rectangle(265, 275, 385, 281);
  text.paint(image, test::gray_level(255));
  const auto found = captions_of(image);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ((found[0] & cv::Rect(266, 240, 118, 40)), cv::Rect(266, 240, 118, 40));
}

TEST(Captions, ABarInABoxIsFound) {
  Image image = gray_micrograph(420, 300);
  Coverage box(420, 300), bar(420, 300);
  box.rectangle(260, 250, 400, 290);
  bar.rectangle(275, 267, 385, 273);
  box.paint(image, test::gray_level(255));
  bar.paint(image, test::gray_level(0));
  const auto found = captions_of(image);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], cv::Rect(260, 250, 140, 40));
}

TEST(Captions, ABarAloneIsFound) {
  for (const int ink : {0, 255}) {
    Image image = gray_micrograph(420, 300);
    Coverage bar(420, 300);
    bar.rectangle(275, 267, 385, 273);
    bar.paint(image, test::gray_level(ink));
    const auto found = captions_of(image);
    ASSERT_EQ(found.size(), 1u) << ink;
    EXPECT_EQ(found[0], cv::Rect(273, 265, 114, 10)) << ink;
  }
}

// A scale bar is one of its kind: many are fibers.
TEST(Captions, FibersAreNone) {
  Image image = gray_micrograph(420, 300);
  Coverage bars(420, 300);
  for (int k = 0; k < 8; ++k) bars.rectangle(20 + 45 * k, 20 + 30 * k, 90 + 45 * k, 26 + 30 * k);
  bars.paint(image, test::gray_level(255));
  EXPECT_TRUE(captions_of(image).empty());
}

TEST(Captions, AFrameIsFound) {
  for (const int paper : {0, 255})
    for (const bool title : {false, true}) {
      const Image picture = gray_micrograph(300, 200);
      Image image(340, 260, 1, 0.5, test::gray_level(paper));
      for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) image.at(x + 20, y + 10) = picture.at(x, y);
      if (title) {
        Coverage text(340, 260);
        add_text(text, 24, 222, "Fig. 3: polished section", 20);
        text.paint(image, test::gray_level(255 - paper));
      }
      cv::Mat found(260, 340, CV_8U, cv::Scalar(0));
      for (const cv::Rect& r : captions_of(image)) found(r).setTo(255);
      const cv::Rect inside(20, 10, 300, 200), surely(22, 12, 296, 196);
      EXPECT_EQ(cv::countNonZero(found(surely)), 0) << paper << title;
      found(inside).setTo(255);
      EXPECT_EQ(cv::countNonZero(found), 340 * 260) << paper << title;
    }
}

TEST(Captions, BarsOfAPaddedPictureAreFound) {
  const Image picture = gray_micrograph(300, 200);
  Image image(300, 300, 1, 0.5, test::gray_level(0));
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 300; ++x) image.at(x, y + 50) = picture.at(x, y);
  const auto found = captions_of(image);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0], cv::Rect(0, 0, 300, 51));
  EXPECT_EQ(found[1], cv::Rect(0, 249, 300, 51));
}

// The picture shines through a panel, which belongs to the caption.
TEST(Captions, APanelBelongsToItsText) {
  for (const float opacity : {0.5f, 1.0f}) {
    Image image = gray_micrograph(420, 300);
    Coverage panel(420, 300), text(420, 300);
    panel.rectangle(0, 250, 420, 300);
    panel.paint(image, test::gray_level(0), opacity);
    add_text(text, 30, 256, "15.0 kV  x 2000", 36);
    text.paint(image, test::gray_level(255));
    for (auto& p : image.pixels)  // as a file stores it
      p = test::gray_level(static_cast<int>(std::lround(255 * linear_to_srgb(p)[0])));
    const auto found = captions_of(image);
    ASSERT_EQ(found.size(), 1u) << opacity;
    EXPECT_EQ(found[0], cv::Rect(0, 250, 420, 50)) << opacity;
  }
}

TEST(Captions, PicturesWithoutTextHaveNone) {
  std::vector<Image> pictures;
  pictures.push_back(gray_micrograph(420, 300, 5));
  // A strip without text, and strips with particles: scattered, and in a row.
  pictures.push_back(gray_micrograph(420, 300));
  for (int y = 250; y < 300; ++y)
    for (int x = 0; x < 420; ++x) pictures.back().at(x, y) = test::gray_level(0);
  pictures.push_back(pictures.back());
  for (const auto& d : test::scatter(420, 50, 25, 3, 10, 2))
    test::draw(pictures.back(), {d.x, d.y + 250, d.radius}, test::gray_level(200));
  pictures.push_back(pictures[1]);
  for (int k = 0; k < 20; ++k) test::draw(pictures.back(), {15.0 + 20 * k, 275, 7}, test::gray_level(220));
  // Discs on one flat color, none at the edge, and a round field of view.
  pictures.emplace_back(300, 300, 1, 1, test::gray_level(0));
  for (int k = 0; k < 36; ++k)
    test::draw(pictures.back(), {30.0 + 48 * (k % 6), 30.0 + 48 * (k / 6), 14}, test::gray_level(200));
  pictures.push_back(gray_micrograph(300, 300));
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      if (std::hypot(x - 149.5, y - 149.5) > 144) pictures.back().at(x, y) = test::gray_level(0);
  // Rows of equal squares, without noise.
  pictures.emplace_back(400, 300, 1, 1, test::gray_level(255));
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 400; ++x)
      if (x % 20 < 12 && y % 20 < 12) pictures.back().at(x, y) = test::gray_level(0);
  // Specks of two lightnesses.
  pictures.emplace_back(300, 300, 1, 1, test::gray_level(0));
  for (const auto& d : test::scatter(300, 300, 600, 1, 6, 4, 1))
    test::draw(pictures.back(), d, test::gray_level(255));
  for (std::size_t k = 0; k < pictures.size(); ++k) EXPECT_TRUE(captions_of(pictures[k]).empty()) << k;
}

// The same area, fraction and colors as without the strip.
TEST(Captions, SegmentIgnoresThemEverywhere) {
  const Image picture = gray_micrograph(260, 180);
  const std::map<std::string, std::string> plain{{"method", "clusters"}, {"delight", "on"}};
  const auto alone = test::run_node("Segment", {{"image", Value::of(picture)}}, plain);
  const Image both = test::with_strip(picture, 30, test::gray_level(0), test::gray_level(255));
  const auto found = test::run_node("Segment", {{"image", Value::of(both)}}, plain);
  const auto &a = alone.output<Profiles>("profiles"), &b = found.output<Profiles>("profiles");
  EXPECT_NEAR(a.observed_area, b.observed_area, 1e-9);
  EXPECT_NEAR(a.area_fraction, b.area_fraction, 0.003);
  EXPECT_NEAR(a.binder_color[0], b.binder_color[0], 0.003f);
  for (const Profile& p : b.profiles) EXPECT_GT(p.centroid.y(), 0.5 * 30);  // y goes up
  const Labels &labels = found.output<Labels>("labels"), &unobserved = found.output<Labels>("unobserved");
  for (int y = 0; y < both.height; ++y)
    for (int x = 0; x < both.width; ++x) {
      const std::size_t i = both.index(x, y);
      ASSERT_EQ(unobserved.ids[i], y >= 180 ? 1 : 0) << x << ' ' << y;
      if (y >= 180) {
        ASSERT_EQ(labels.ids[i], 0);
      }
    }
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_NE(found.warnings[0].find("rows 180 to 209 show a caption"), std::string::npos) << found.warnings[0];
  EXPECT_NE(found.warnings[0].find("bar of 65"), std::string::npos) << found.warnings[0];

  auto keeping = plain;
  keeping["find_objects"] = "false";
  const auto kept = test::run_node("Segment", {{"image", Value::of(both)}}, keeping);
  EXPECT_GT(kept.output<Profiles>("profiles").observed_area, b.observed_area);
  EXPECT_TRUE(kept.warnings.empty());
  // Given labels of the letters are no particles either.
  Labels given = labels;
  given.classes.push_back(0);
  for (std::size_t i = both.index(0, 180); i < both.pixels.size(); ++i)
    if (both.pixels[i][0] > 0.5f) given.ids[i] = given.count();
  const auto measured =
      test::run_node("Segment", {{"image", Value::of(both)}, {"labels", Value::of(given)}}, {});
  EXPECT_EQ(measured.output<Profiles>("profiles").profiles.size(), b.profiles.size());
  EXPECT_NEAR(measured.output<Profiles>("profiles").observed_area, a.observed_area, 1e-9);
}

// What the network misses within an object belongs to it, but not the material within a frame.
TEST(Objects, HolesBelongToAnObject) {
  const int w = 100, h = 80;
  const Image image(w, h, 1, 1);
  std::vector<float> strip(w * h, 0), frame(w * h, 0);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (y >= 60 && (x % 9 > 3 || y < 63 || y > 76 || x < 9 || x > 90))
        strip[y * w + x] = 0.95f;  // between letters
      if (x < 5 || y < 5 || x >= 95 || y >= 75) frame[y * w + x] = 0.95f;
    }
  for (const auto* map : {&strip, &frame}) {
    IgnoredPixels ignored;
    std::vector<FoundObject> objects;
    add_objects_of_network(*map, 0, image, ignored, objects);
    ASSERT_EQ(objects.size(), 1u);
    const auto n = std::count(ignored.begin(), ignored.end(), 1);
    EXPECT_EQ(n, map == &strip ? 20 * w : 2 * 5 * w + 2 * 5 * 70);
    EXPECT_EQ(objects[0].pixels, n);
  }
}

TEST(Captions, TheStripOfAMicrographIsIgnored) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto file = (data / "reports" / "sem_strip.jpg").string();
  const auto loaded = test::run_node("LoadImage", {}, {{"path", file}});
  const Image& whole = loaded.output<Image>("image");
  const auto captions = captions_of(whole);
  ASSERT_EQ(captions.size(), 1u);
  EXPECT_EQ(captions[0], cv::Rect(0, 650, 900, 70));
  // The lower right corner suffices to see that the caption leaves no profiles.
  Image corner(360, 390, 1, whole.pixel_size);
  for (int y = 0; y < corner.height; ++y)
    for (int x = 0; x < corner.width; ++x) corner.at(x, y) = whole.at(540 + x, 330 + y);
  const auto found = test::run_node("Segment", {{"image", Value::of(corner)}}, {{"method", "clusters"}});
  const Profiles& p = found.output<Profiles>("profiles");
  EXPECT_EQ(p.profiles.size(), 10u);
  for (const Profile& q : p.profiles) EXPECT_GT(q.centroid.y() / corner.pixel_size, 70);  // y goes up
  const Labels& unobserved = found.output<Labels>("unobserved");
  EXPECT_EQ(std::count(unobserved.ids.begin(), unobserved.ids.end(), 1), 360 * 70);
}

}  // namespace
}  // namespace terrazzo
