#include <gtest/gtest.h>

#include "nodes/common/io/stroke_text.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/image.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

TEST(DrawStrokes, DrawsInTurnAndTellsWhere) {
  Strokes s;
  s.strokes = {strokes::read_stroke("4: 10 10"), strokes::read_stroke("area: 8 8, 20 8, 20 20, 8 20")};
  const Image picture(32, 24, 2, 1, Vec3f::Constant(0.5f));
  const auto r = test::run_node("DrawStrokes", {{"image", Value::of(picture)}, {"strokes", Value::of(s)}},
                                {{"colors", "[\"#ff0000\", \"#0000ff\"]"}});
  const Image &drawn = r.output<Image>("image"), &mask = r.output<Image>("mask");
  EXPECT_EQ(drawn.at(7, 10), Vec3f(1, 0, 0));
  EXPECT_EQ(drawn.at(10, 10), Vec3f(0, 0, 1));
  EXPECT_EQ(drawn.at(19, 19, 1), Vec3f(0, 0, 1));
  EXPECT_EQ(drawn.at(20, 20), Vec3f::Constant(0.5f));
  for (std::size_t i = 0; i < mask.pixels.size(); ++i)
    EXPECT_EQ(mask.pixels[i] == Vec3f::Ones(), drawn.pixels[i] != picture.pixels[i]);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("DrawStrokes", {{"image", Value::of(picture)}, {"strokes", Value::of(s)}},
                             {{"colors", "[reddish]"}});
            }),
            "bad-color");
}

}  // namespace
}  // namespace terrazzo
