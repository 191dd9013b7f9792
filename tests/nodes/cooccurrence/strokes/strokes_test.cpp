#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "nodes/common/io/stroke_text.h"
#include "nodes/data/strokes.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using strokes::read_stroke;
using strokes::write_stroke;

TEST(Strokes, WordsAreLinesAndAreas) {
  const Strokes s =
      test::run_node(
          "Strokes", {},
          {{"strokes", R"(["6: 10 20, 30.5 -4", " 2.5 :1 2", "area: 0 0, 9 0, 5 8; 1 1,2 1,2 2"])"}})
          .output<Strokes>("strokes");
  ASSERT_EQ(s.strokes.size(), 3u);
  EXPECT_EQ(s.strokes[0].radius, 6);
  EXPECT_EQ(s.strokes[0].parts, (std::vector<std::vector<Vec2>>{{{10, 20}, {30.5, -4}}}));
  EXPECT_EQ(s.strokes[1].parts[0].size(), 1u);
  EXPECT_TRUE(s.strokes[2].area);
  EXPECT_EQ(s.strokes[2].parts.size(), 2u);
}

TEST(Strokes, MalformedWordsAreRefused) {
  for (const char* bad : {"", "6", "six: 1 2", "6: 1", "6: 1 2 3", "6: 1 2,", "6: 1 2; 3 4", "0: 1 2",
                          "-1: 1 2", "area: 1 2, 3 4", "6: nan 1", "6: 1e9 1", "inf: 1 1", "6: 1 2, , 3 4"})
    EXPECT_EQ(test::code_of([&] { read_stroke(bad); }), "bad-stroke") << bad;
}

TEST(Strokes, WrittenWordsReadBackAsTheSameNumbers) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random r(seed, 3);
    Stroke s;
    s.area = r.below(2);
    s.radius = s.area ? 0 : r.uniform(0.1, 50);
    s.parts.resize(s.area ? 1 + r.below(3) : 1);
    for (auto& part : s.parts)
      for (std::size_t i = 0; i < 3 + r.below(5); ++i)
        part.emplace_back(r.uniform(-10, 500), r.normal() * 1e-3);
    const Stroke back = read_stroke(write_stroke(s));
    EXPECT_EQ(back.parts, s.parts);
    EXPECT_EQ(back.radius, s.radius);
    EXPECT_EQ(back.area, s.area);
  }
}

TEST(Strokes, SurviveTheDiskAndDamage) {
  Strokes s;
  s.strokes.push_back(read_stroke("6: 10 20, 30 40"));
  s.strokes.push_back(read_stroke("area: 0 0, 9 0, 5 8; 1 1, 2 1, 2 2"));
  const ValueType& type = value_type<Strokes>();
  BufferWriter w;
  type.encode(&s, w);
  Reader r(w.buffer.data(), w.buffer.size());
  const auto back = std::static_pointer_cast<const Strokes>(type.decode(r));
  BufferWriter again;
  type.encode(back.get(), again);
  EXPECT_EQ(again.buffer, w.buffer);
  for (std::size_t n = 0; n < w.buffer.size(); ++n) {
    Reader cut(w.buffer.data(), n);
    EXPECT_EQ(test::code_of([&] { type.decode(cut); }), "damaged") << n;
  }
  const auto json = type.describe(&s);
  EXPECT_EQ(json["strokes"][0]["points"][1][0], 30);
  EXPECT_EQ(json["strokes"][1]["parts"].size(), 2u);
}

}  // namespace
}  // namespace terrazzo
