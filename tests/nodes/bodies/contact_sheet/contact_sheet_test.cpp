#include <gtest/gtest.h>

#include <set>

#include "nodes/bodies/contact_sheet/resize.h"
#include "nodes/bodies/contact_sheet/sheet.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace contact_sheet;

using test::run_node;

Image plain(int width, int height, const Vec3f& color) { return Image(width, height, 1, 1, color); }

TEST(ContactSheet, PlacesPicturesInReadingOrder) {
  const Vec3f red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1);
  const auto run = run_node("ContactSheet",
                            {{"images", Value::of(plain(50, 50, red))},
                             {"images", Value::of(plain(50, 25, green))},
                             {"images", Value::of(plain(20, 20, blue))},
                             {"images", Value::of(plain(10, 40, red))}},
                            {{"cell", "100"}});
  const Image& sheet = run.output<Image>("image");
  const int gap = 8;
  ASSERT_EQ(sheet.width, 2 * 100 + 3 * gap);
  ASSERT_EQ(sheet.height, 2 * 100 + 3 * gap);
  EXPECT_LT((sheet.at(gap + 50, gap + 50) - red).norm(), 1e-4);
  EXPECT_LT((sheet.at(2 * gap + 150, gap + 50) - green).norm(), 1e-4);
  EXPECT_LT((sheet.at(2 * gap + 150, gap + 10) - Vec3f::Ones()).norm(),
            1e-4);  // above the image, which is shorter than its cell
  EXPECT_LT((sheet.at(gap + 50, 2 * gap + 150) - blue).norm(), 1e-4);
  EXPECT_LT((sheet.at(2 * gap + 150, 2 * gap + 150) - red).norm(), 1e-4);
  EXPECT_LT((sheet.at(2, 2) - Vec3f::Ones()).norm(), 1e-4);
}

TEST(ContactSheet, CaptionsTakeARowBelow) {
  const Value image = Value::of(plain(64, 64, Vec3f::Zero()));
  const auto without = run_node("ContactSheet", {{"images", image}});
  const auto with = run_node(
      "ContactSheet", {{"images", image}},
      {{"captions", "[a very long caption that does not fit below so small a picture however one sets it]"}});
  const Image &a = without.output<Image>("image"), &b = with.output<Image>("image");
  EXPECT_EQ(a.width, b.width);
  ASSERT_GT(b.height, a.height + 15);
  int ink = 0, right = 0;
  for (int y = a.height - 20; y < b.height; ++y)
    for (int x = 0; x < b.width; ++x)
      if (b.at(x, y).x() < 0.4f) ++ink, right = std::max(right, x);
  EXPECT_GT(ink, 300);
  EXPECT_LT(right, b.width - 20);
}

TEST(ContactSheet, LabelsGetColorsThatStayApart) {
  std::set<std::tuple<float, float, float>> seen;
  for (int id = 1; id <= 2000; ++id) {
    const Vec3f c = label_color(id), next = label_color(id + 1);
    seen.insert({c.x(), c.y(), c.z()});
    EXPECT_GT((c - next).norm(), 0.1) << id;
    EXPECT_GT(c.sum(), 0.3) << id;
  }
  EXPECT_EQ(seen.size(), 2000u);
  Labels labels;
  labels.width = 2;
  labels.height = 1;
  labels.ids = {0, 1};
  labels.classes = {0};
  const auto run =
      run_node("ContactSheet", {{"images", Value::of(labels)}}, {{"cell", "64"}, {"background", "dark"}});
  EXPECT_GT(run.output<Image>("image").height, 30);
}

TEST(ContactSheet, TakesTheFirstSectionOfAStack) {
  Image stack(10, 10, 2, 1);
  for (int i = 0; i < 100; ++i) stack.pixels[i] = Vec3f(0, 1, 0), stack.pixels[100 + i] = Vec3f(1, 0, 0);
  const Image sheet = contact_sheet::contact_sheet({stack}, {});
  EXPECT_LT((sheet.at(sheet.width / 2, sheet.height / 2) - Vec3f(0, 1, 0)).norm(), 1e-3);
}

TEST(Resized, KeepsTheMeanAndConstants) {
  Image noise(97, 61, 1, 1);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), small = mean;
  for (std::size_t i = 0; i < noise.pixels.size(); ++i) {
    Random r(3, 0, i);
    noise.pixels[i] = Vec3f(0.3f + 0.1f * static_cast<float>(r.uniform()), 0.5f, 0.2f);
    mean += noise.pixels[i].cast<double>() / noise.pixels.size();
  }
  const Image reduced = resized(noise, 0, 30, 20);
  for (const Vec3f& c : reduced.pixels) small += c.cast<double>() / reduced.pixels.size();
  EXPECT_LT((mean - small).norm(), 2e-3);
  for (const Image& i : {resized(noise, 0, 30, 20), resized(noise, 0, 300, 200)})
    for (const Vec3f& c : i.pixels) ASSERT_NEAR(c.y(), 0.5f, 1e-4);
}

std::string code_of(const std::multimap<std::string, Value>& inputs,
                    const std::map<std::string, std::string>& parameters = {}) {
  return test::code_of([&] { run_node("ContactSheet", inputs, parameters); });
}

TEST(ContactSheet, SaysWhatIsWrong) {
  const Value good = Value::of(plain(4, 4, Vec3f::Ones()));
  Image nan = plain(4, 4, Vec3f::Ones());
  nan.at(2, 3).y() = NAN;
  EXPECT_EQ(code_of({{"images", good}}), "");
  EXPECT_EQ(code_of({{"images", Value::of(Image{})}}), "empty-image");
  EXPECT_EQ(code_of({{"images", Value::of(nan)}}), "bad-pixels");
  EXPECT_EQ(code_of({{"images", good}}, {{"captions", "[one, two]"}}), "too-many-captions");
  EXPECT_NE(code_of({}), "");
}

}  // namespace
}  // namespace terrazzo
