// The shaders' passes compared with the processor's, on Mesa's software renderer.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>

#include "graph/diagnostic.h"
#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "tests/nodes/solids/solid_optimize/exemplars.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace so = solids;

class SolidGl : public ::testing::Test {
 protected:
  // One for all tests, because the software renderer takes a second to compile the shaders.
  static void SetUpTestSuite() {
    try {
      gl = std::make_unique<so::BlockGl>(GlDevice::Cpu);
    } catch (const Error& e) {
      why = e.what();
    }
  }
  static void TearDownTestSuite() { gl.reset(); }
  void SetUp() override {
    if (!gl) GTEST_SKIP() << why;
  }
  // Fraction of voxels that differ by more than 1/1000 of the exemplar's standard deviation.
  double difference(const std::vector<so::SolidExemplar>& exemplars, const so::SolidOptions& s) {
    const auto a = so::optimize_solid(exemplars, s, Work()),
               b = so::optimize_solid(exemplars, s, Work(), gl.get());
    EXPECT_EQ(a.size, b.size);
    EXPECT_EQ(a.sources.texel.size(), b.sources.texel.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.field.channel[0].size(); ++i) {
      float most = 0;
      for (std::size_t c = 0; c < a.field.channel.size(); ++c)
        most = std::max(most, std::abs(a.field.channel[c][i] - b.field.channel[c][i]));
      count += !(most <= 1e-3f);
    }
    for (std::size_t k = 0; k < a.measures.size(); ++k) {
      EXPECT_NEAR(a.measures[k].patches, b.measures[k].patches, 1e-3);
      EXPECT_NEAR(a.measures[k].bands[0], b.measures[k].bands[0], 1e-3);
      EXPECT_NEAR(a.measures[k].copied, b.measures[k].copied, 1e-3);
    }
    return static_cast<double>(count) / static_cast<double>(a.field.channel[0].size());
  }
  static std::unique_ptr<so::BlockGl> gl;
  static std::string why;
};
std::unique_ptr<so::BlockGl> SolidGl::gl;
std::string SolidGl::why;

so::SolidOptions small(const Vec3i& size) {
  so::SolidOptions s;
  s.size = size;
  s.levels = 3;
  s.iterations = {2};
  s.method = so::SolidMethod::Blockwise;
  s.finish = 1;
  s.blockwise_limits.whole = 1;
  s.blockwise_limits.probe = 20;
  s.blockwise_limits.closed = 20;
  return s;
}

TEST_F(SolidGl, MakesWhatTheProcessorMakes) {
  EXPECT_LT(difference({test::exemplar_of(test::blobs(48, 64, 8, 1))}, small(Vec3i::Constant(32))), 0.01);
}

TEST_F(SolidGl, MakesItWhereTheProbeIsEverythingToo) {
  so::SolidOptions s = small(Vec3i::Constant(32));
  s.blockwise_limits.closed = 32;
  EXPECT_LT(difference({test::exemplar_of(test::blobs(48, 64, 8, 1))}, s), 0.01);
}

TEST_F(SolidGl, MakesTheSameBlocks) {
  so::SolidOptions s = small(Vec3i(25, 24, 33));
  s.blocks = Vec3i(1, 2, 2);
  s.block = 2;
  EXPECT_LT(difference({test::exemplar_of(test::blobs(48, 48, 8, 1))}, s), 0.01);
}

TEST_F(SolidGl, TakesTwoExemplarsMasksAndGreyAndKeepsSources) {
  so::SolidOptions s = small(Vec3i(32, 32, 32));
  s.sources = true;
  s.plane = {0, -1, 1};
  Image gray = test::blobs(48, 48, 7, 12), other = test::blobs(64, 56, 7, 3);
  for (auto* image : {&gray, &other})
    for (auto& p : image->pixels) p = Vec3f::Constant(p.mean());
  so::SolidExemplar masked = test::exemplar_of(other);
  masked.usable.assign(masked.pixels.size(), 1);
  for (int i = 0; i < 56; ++i)
    for (int x = 45; x < 64; ++x) masked.usable[static_cast<std::size_t>(i) * 64 + x] = 0;
  EXPECT_LT(difference({test::exemplar_of(gray), masked}, s), 0.01);
}

TEST_F(SolidGl, StopsWhenCancelled) {
  const so::SolidExemplar e = test::exemplar_of(test::blobs(48, 48, 8, 1));
  for (const double stop : {0.4, 0.7}) {
    std::atomic<bool> cancel{false};
    const Work::Report report = [&](double fraction, const std::string&) { cancel = fraction >= stop; };
    EXPECT_THROW(so::optimize_solid({e}, small(Vec3i::Constant(24)), Work(&cancel, &report), gl.get()),
                 Cancelled)
        << stop;
  }
}

TEST(SolidDevice, TheNodeSaysWhichItTook) {
  try {
    EglContext probe(GlDevice::Cpu);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  const auto run = [](const char* method, const char* device) {
    return test::run_node("SolidOptimize", {{"exemplar", Value::of<Image>(test::blobs(64, 64, 8, 1))}},
                          {{"size", "32"}, {"iterations", "2"}, {"method", method}, {"device", device}});
  };
  EXPECT_TRUE(run("blockwise", "cpu").warnings.empty());
  const auto gl = run("blockwise", "gl");
  ASSERT_EQ(gl.warnings.size(), 1u);
  EXPECT_NE(gl.warnings[0].find("OpenGL"), std::string::npos);
  EXPECT_EQ(run("blockwise", "auto").warnings.size(), 1u);
  EXPECT_TRUE(run("coherence", "auto").warnings.empty());
  try {
    run("coherence", "gl");
    ADD_FAILURE() << "device gl was accepted without method blockwise";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().parameter, "device");
  }
}

}  // namespace
}  // namespace terrazzo
