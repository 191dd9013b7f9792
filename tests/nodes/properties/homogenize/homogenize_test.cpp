// The node: which voxels are which phase, what it reports, and what it refuses.
#include <gtest/gtest.h>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/data/table.h"
#include "nodes/properties/homogenize/bounds.h"
#include "nodes/properties/homogenize/phases.h"
#include "tests/nodes/properties/homogenize/models.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace homogenize;
using test::kAmple;
using Parameters = std::map<std::string, std::string>;

constexpr int kEdge = 8;

Volume numbers(const std::function<float(int x)>& value, bool periodic = true) {
  Volume v;
  add_number_grid(v, "density", Vec3i::Constant(kEdge), Vec3::Constant(0.1), {},
                  [&](std::size_t i) { return value(static_cast<int>(i) % kEdge); });
  (periodic ? v.resolution : v.extent) = Vec3i::Constant(kEdge);
  return v;
}

Volume labels(const std::function<int(int x)>& value) {
  Volume v;
  add_id_grid(v, "id", Vec3i::Constant(kEdge), Vec3::Constant(0.1), {},
              [&](std::size_t i) { return value(static_cast<int>(i) % kEdge); });
  v.resolution = Vec3i::Constant(kEdge);
  return v;
}

test::NodeRun run(const Volume& v, const Parameters& p) {
  return test::run_node("Homogenize", {{"volume", Value::of(v)}}, p);
}

PhaseMap phases(const Volume& v, std::size_t expected = 0, const Particles* particles = nullptr) {
  return read_phases(v, "", particles, expected, kAmple, {});
}

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(HomogenizePhases, AreTheNumbersOfAGridInOrder) {
  const PhaseMap map = phases(numbers([](int x) { return x < 2 ? 170 : x < 5 ? 0 : 85; }));
  EXPECT_EQ(map.names, (std::vector<std::string>{"0", "85", "170"}));
  EXPECT_EQ(map.fraction, (std::vector<double>{3.0 / 8, 3.0 / 8, 2.0 / 8}));
  EXPECT_EQ(map.phase[0], 2);
  EXPECT_EQ(map.phase[3], 0);
}

TEST(HomogenizePhases, OfParticlesAreTheirClassesAndVoids) {
  Particles p;
  p.voids = {};
  p.resize(4);
  p.cls = {3, 1, 3, 1};
  p.voids = {0, 0, 0, 1};
  const Volume v = labels([](int x) { return x < 4 ? x : -1; });
  const PhaseMap map = phases(v, 0, &p);
  EXPECT_EQ(map.names, (std::vector<std::string>{"binder", "class 1", "class 3", "void"}));
  EXPECT_EQ(std::vector<std::uint8_t>(map.phase.begin(), map.phase.begin() + kEdge),
            (std::vector<std::uint8_t>{2, 1, 2, 3, 0, 0, 0, 0}));
  p.resize(2);
  EXPECT_EQ(test::code_of([&] { phases(v, 0, &p); }), "size-mismatch");
}

TEST(HomogenizePhases, OfLabelsAreTwoIfThereAreTwoValues) {
  const Volume v = labels([](int x) { return x < 4 ? x : -1; });
  EXPECT_EQ(phases(v, 2).names, (std::vector<std::string>{"binder", "particles"}));
  EXPECT_EQ(phases(v, 5).names, (std::vector<std::string>{"-1", "0", "1", "2", "3"}));
  // The same in a grid of real numbers, and with more labels than there may be phases.
  EXPECT_EQ(phases(numbers([](int x) { return x < 3 ? 0 : -1; }), 2).fraction[1], 3.0 / 8);
  Volume many;
  add_id_grid(many, "id", Vec3i::Constant(kEdge), Vec3::Ones(), {},
              [](std::size_t i) { return static_cast<std::int32_t>(i) - 1; });
  EXPECT_EQ(phases(many, 2).fraction[1], 511.0 / 512);
  EXPECT_EQ(test::code_of([&] { phases(many, 3); }), "too-many-phases");
}

TEST(HomogenizePhases, OfCoverageAreOutsideAndInside) {
  const PhaseMap map = phases(numbers([](int x) { return static_cast<float>(x) / 7; }));
  EXPECT_EQ(map.names, (std::vector<std::string>{"outside", "inside"}));
  EXPECT_EQ(map.fraction[1], 0.5);
  EXPECT_EQ(test::code_of([] { phases(numbers([](int x) { return 0.7F * static_cast<float>(x); })); }),
            "not-phases");
}

TEST(HomogenizePhases, KeepTheirSharesAtHalfTheResolution) {
  const auto map = test::phase_map({8, 7, 1}, 2, [](int x, int, int) { return x < 4 ? 1 : 0; }, {1, 2, 3});
  const PhaseMap half = halved(map, {});
  EXPECT_EQ(half.box.size, Vec3i(4, 4, 1));
  EXPECT_EQ(half.fraction[1], 0.5);
  EXPECT_EQ(half.box.spacing, Vec3(2, 3.5, 3));
}

TEST(HomogenizeBounds, AreThoseOfTwoPhasesInClosedForm) {
  const double f = 0.3, a = 2, b = 11;
  const Bounds k = hashin_shtrikman({1 - f, f}, {a, b});
  EXPECT_NEAR(k.low, a + f / (1 / (b - a) + (1 - f) / (3 * a)), 1e-12);
  EXPECT_NEAR(k.high, b + (1 - f) / (1 / (a - b) + f / (3 * b)), 1e-12);
  const Elastic soft{1, 0.3}, stiff{9, 0.2};
  const auto bulk = [](const Elastic& e) { return e.lambda() + 2 * e.mu() / 3; };
  const ElasticBounds e = hashin_shtrikman({1 - f, f}, std::vector<Elastic>{soft, stiff});
  const double k1 = bulk(soft), g1 = soft.mu();
  EXPECT_NEAR(e.bulk.low, k1 + f / (1 / (bulk(stiff) - k1) + 3 * (1 - f) / (3 * k1 + 4 * g1)), 1e-12);
  EXPECT_NEAR(e.shear.low,
              g1 + f / (1 / (stiff.mu() - g1) + 6 * (1 - f) * (k1 + 2 * g1) / (5 * g1 * (3 * k1 + 4 * g1))),
              1e-12);
  EXPECT_EQ(hashin_shtrikman({0.5, 0.5}, {0, 3}).low, 0);
}

// The tortuosity of TauFactor: D_eff = D ε / τ, here of straight channels and of a volume with a wall.
TEST(Homogenize, ReportsTensorTortuosityAndErrors) {
  const auto r = run(numbers([](int x) { return x < 4 ? 1 : 0; }), {{"values", "[0, 2]"}});
  EXPECT_NEAR(r.metrics.at("effective_yy"), 1, 1e-5);
  EXPECT_NEAR(r.metrics.at("tortuosity_y"), 1, 1e-5);
  EXPECT_EQ(r.metrics.at("effective_xx"), 0);
  EXPECT_EQ(r.metrics.count("tortuosity_x"), 0u);
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find("do not connect along x"), std::string::npos);
  EXPECT_NEAR(r.metrics.at("voxel_error"), 0, 1e-6);
  EXPECT_NEAR(r.output<Table>("table").number(1, "half_resolution"), 1, 1e-5);  // effective yy
  const auto& t = r.output<Table>("tensor");
  EXPECT_EQ(t.columns, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_NEAR(t.number(1, "y"), 1, 1e-5);
  EXPECT_EQ(t.number(0, "x"), 0);
}

TEST(Homogenize, FindsThePropertiesOfOneMaterial) {
  const Volume v = numbers([](int) { return 7; }, false);
  EXPECT_NEAR(run(v, {{"values", "[3]"}}).metrics.at("effective_mean"), 3, 1e-5);
  const auto stiff = run(v, {{"property", "stiffness"}, {"values", "[70, 0.2]"}});
  EXPECT_NEAR(stiff.metrics.at("young"), 70, 1e-3);
  EXPECT_NEAR(stiff.metrics.at("poisson"), 0.2, 1e-5);
  // An empty box with walls around it: a duct of 0.8 mm.
  const auto flow = run(v, {{"property", "permeability"}, {"values", "[1]"}, {"directions", "[z]"}});
  EXPECT_NEAR(flow.metrics.at("effective_zz") / (0.035144 * 0.64 * (1 + 4.0 / 64)), 1, 0.01);
  EXPECT_EQ(flow.metrics.count("effective_xx"), 0u);
}

TEST(Homogenize, NamesTheParameterOfABadValue) {
  const Volume v = numbers([](int x) { return x < 4 ? 1 : 0; });
  const auto refuses = [&](const Parameters& p, const std::string& text) {
    const std::string message = message_of([&] { run(v, p); });
    EXPECT_NE(message.find(text), std::string::npos) << message;
  };
  refuses({{"values", "[1, -2]"}}, "the value -2 is negative");
  refuses({{"values", "[0, 0]"}}, "every phase has the value 0");
  refuses({{"values", "[1, 2, 3]"}},
          "there are values for 3 phases, but the volume has 2: 0 with 50 %, 1 with 50 %");
  refuses({{"values", "[1, 0.5]"}, {"property", "permeability"}}, "the value 0.5 is neither 0 nor 1");
  refuses({{"values", "[1, 0.3, 2]"}, {"property", "stiffness"}}, "3 numbers are not pairs");
  refuses({{"values", "[1, 0.5, 2, 0.3]"}, {"property", "stiffness"}}, "Poisson's ratio 0.5");
  refuses({{"values", "[1, 0.3, 2, 0.3]"}, {"property", "stiffness"}, {"boundary", "fixed"}},
          "periodic volumes only");
  refuses({{"values", "[1, 2]"}, {"directions", "[x, up]"}}, "'up' is not a direction");
  refuses({{"values", "[1, 1000]"}, {"iterations", "1"}, {"tolerance", "1e-9"}},
          "after 1 iterations the residual is");
}

// Voxels that are no longer cubes at half the resolution give no voxel_error; a single layer may have any
// thickness.
TEST(Homogenize, HalvesOnlyWhatStaysCubic) {
  for (const auto& [size, has] : {std::pair(Vec3i(8, 8, 9), false), std::pair(Vec3i(8, 8, 1), true)}) {
    Volume v;
    add_number_grid(v, "phase", size, Vec3::Constant(0.1), {},
                    [](std::size_t i) { return i % 8 < 4 ? 0.0F : 1.0F; });
    v.resolution = size;
    const auto r = run(v, {{"property", "stiffness"}, {"values", "[1, 0.3, 2, 0.3]"}});
    EXPECT_EQ(r.metrics.count("voxel_error"), has ? 1u : 0u) << size.transpose();
    EXPECT_GT(r.metrics.at("young"), 1);
  }
}

// The electrode of TauFactor's examples: its three phases, and pores that connect in all directions.
TEST(Homogenize, ReadsTheNumbersOfAScan) {
  const auto file = test::shared_data() / "media" / "electrode.tiff";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "the scan is not there";
  const auto scan = test::run_node("LoadVolume", {}, {{"path", file.string()}, {"spacing", "0.001"}});
  const PhaseMap map = phases(scan.output<Volume>("volume"));
  EXPECT_EQ(map.names, (std::vector<std::string>{"0", "85", "170"}));
  EXPECT_NEAR(map.fraction[0], 0.450, 5e-4);
  EXPECT_NEAR(map.fraction[1], 0.400, 5e-4);
  EXPECT_NEAR(map.fraction[2], 0.150, 5e-4);
}

}  // namespace
}  // namespace terrazzo
