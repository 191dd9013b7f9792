// Phases of a volume that are hidden: where their surface lies, and what the colors beside it are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/hidden_phases.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace carving;

const Vec3i kSize(32, 40, 24);

// Balls at random places, which continue across the faces of a volume that repeats.
HiddenVoxels hidden_balls(bool periodic) {
  HiddenVoxels out{kSize, periodic, std::vector<std::uint8_t>(voxels_in(kSize), 0)};
  const Vec3 size = kSize.cast<double>();
  for (int ball = 0; ball < 12; ++ball) {
    Random r(1, 2, ball);
    const Vec3 center(r.uniform(0, size.x()), r.uniform(0, size.y()), r.uniform(0, size.z()));
    const double radius = r.uniform(3, 7);
    for (int z = 0; z < kSize.z(); ++z)
      for (int y = 0; y < kSize.y(); ++y)
        for (int x = 0; x < kSize.x(); ++x) {
          const Vec3 d = Vec3(x + 0.5, y + 0.5, z + 0.5) - center;
          if ((periodic ? nearest_image(d, size) : d).norm() < radius) out.in[voxel_at(x, y, z, kSize)] = 1;
        }
  }
  return out;
}

// How many of the 27 voxels around one are hidden; fewer near the faces of a volume that does not repeat.
std::pair<int, int> hidden_around(const HiddenVoxels& h, const Vec3i& at) {
  int hidden = 0, all = 0;
  for (int k = 0; k < 27; ++k) {
    Vec3i p = at + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    for (int a = 0; a < 3; ++a) {
      if (h.periodic) p[a] = wrap_index(p[a], h.size[a]);
      if (p[a] < 0 || p[a] >= h.size[a]) p[a] = at[a];
    }
    hidden += h.in[voxel_at(p.x(), p.y(), p.z(), h.size)];
    ++all;
  }
  return {hidden, all};
}

class GrayPaint : public Paint {
 public:
  Vec3f at(const Vec3f&, const Vec3f&, bool) const override { return Vec3f::Constant(0.5f); }
  Vec3f period() const override { return kSize.cast<float>() / kSize.maxCoeff(); }
};

// The part of the voxels around a point of the block that are hidden; 1 outside the block.
double hidden_at(const HiddenVoxels& h, const Vec3& world) {
  const Vec3 p = world * kSize.maxCoeff();
  if ((p.array() < 0).any() || (p.array() >= kSize.cast<double>().array()).any()) return 1;
  const auto [hidden, all] = hidden_around(h, p.cast<int>());
  return double(hidden) / all;
}

// Rays cross the block, some without meeting what is visible, and some start in holes.
TEST(HiddenPhases, RaysPassWhatIsHiddenAndMeetTheRest) {
  for (const bool periodic : {true, false})
    for (const bool most : {false, true}) {  // few voxels are hidden, or few are visible
      HiddenVoxels h = hidden_balls(periodic);
      if (most)
        for (auto& in : h.in) in = !in;
      const HiddenVoid hole = hidden_void(h, 0.25, {});
      const GrayPaint gray;
      const auto block =
          block_solid(gray, 0, 0.001,
                      {&hole.particles, &hole.shapes, 1, {}, [&](const Vec3f& p) { return hole.holds(p); }});
      int met = 0, passed = 0;
      for (int k = 0; k < 3000; ++k) {
        Random r(3, 4, k);
        const Vec3 direction = Vec3(r.normal(), r.normal(), r.normal()).normalized();
        const Vec3 through =
            Vec3(r.uniform(), r.uniform(), r.uniform()).cwiseProduct(gray.period().cast<double>());
        const bool within = k % 3 == 0;
        if (within && hidden_at(h, through) < 1) continue;
        const Vec3 origin = within ? through : Vec3(through - 3 * direction);
        SurfacePoint s;
        const bool found = block->nearest(origin.cast<float>(), direction.cast<float>(), s);
        EXPECT_EQ(block->any(origin.cast<float>(), direction.cast<float>()), found);
        const double end = found ? (s.position.cast<double>() - origin).norm() : 6;
        // The surface is smooth: it may cut off half of a voxel.
        for (double t = 0; t < end - 0.5 / kSize.maxCoeff(); t += 1e-3)
          ASSERT_GT(hidden_at(h, origin + t * direction), 0) << "ray " << k << " passes what is visible";
        if (found) {
          EXPECT_LT(hidden_at(h, s.position.cast<double>() + 1e-4 * direction), 1) << "ray " << k;
          EXPECT_LT(s.face.dot(direction.cast<float>()), 1e-4f);
        }
        ++(found ? met : passed);
      }
      EXPECT_GT(met, 300);
      EXPECT_EQ(passed > 100, most);
    }
}

// Its surface lies exactly in the block's lower face.
TEST(HiddenPhases, AHiddenLayerIsOpenWhereItEndsInAFace) {
  HiddenVoxels h{kSize, true, std::vector<std::uint8_t>(voxels_in(kSize), 0)};
  std::fill_n(h.in.begin(), h.in.size() / 2, 1);
  const HiddenVoid hole = hidden_void(h, 0.25, {});
  const GrayPaint gray;
  const auto block = block_solid(
      gray, 0, 0.001, {&hole.particles, &hole.shapes, 1, {}, [&](const Vec3f& p) { return hole.holds(p); }});
  const float height = gray.period().z();
  for (int k = 0; k < 500; ++k) {
    Random r(7, 8, k);
    const Vec3f at(static_cast<float>(r.uniform(0.3, 0.5)), static_cast<float>(r.uniform(0.4, 0.6)), 0);
    const Vec3f up = Vec3f(0.1f * static_cast<float>(r.normal()), 0.1f * static_cast<float>(r.normal()), 1);
    const Vec3f d = up.normalized();
    SurfacePoint s;
    ASSERT_TRUE(block->nearest(at - d, d, s));
    EXPECT_NEAR(s.position.z(), height / 2, 0.002f) << k;
    ASSERT_TRUE(block->nearest(at + Vec3f(0, 0, height) + d, -d, s));
    EXPECT_NEAR(s.position.z(), height, 1e-4f) << k;
  }
}

TEST(HiddenPhases, TheSurfaceOfABallIsWhereTheBallEnds) {
  HiddenVoxels h{Vec3i::Constant(32), true, std::vector<std::uint8_t>(32768, 0)};
  const double radius = 10;
  for (std::size_t i = 0; i < h.in.size(); ++i)
    h.in[i] = (Vec3(i % 32, i / 32 % 32, i / 1024) - Vec3::Constant(15.5)).norm() < radius;
  const Mesh mesh = hidden_void(h, 0.5, {}).shapes.shapes[0].mesh;
  double sum = 0, most = 0;
  for (const Vec3& v : mesh.vertices) {
    const double off = v.norm() / 0.5 - radius;
    sum += off;
    most = std::max(most, std::abs(off));
  }
  EXPECT_LT(std::abs(sum / mesh.vertices.size()), 0.1);
  EXPECT_LT(most, 0.7);
}

Volume phases_of(const HiddenVoxels& h) {
  initialize_openvdb();
  Volume out;
  out.resolution = h.size;
  out.grids.push_back(dense_grid<openvdb::Int32Grid>("phase", h.size, 0.25, {},
                                                     [&](std::size_t i) { return h.in[i] ? 2 : 1; }));
  return out;
}

TEST(HiddenPhases, VoxelsOfThePhasesAreHidden) {
  const HiddenVoxels h = hidden_balls(true);
  EXPECT_EQ(hidden_voxels(phases_of(h), {2}).in, h.in);
  EXPECT_EQ(hidden_voxels(phases_of(h), {2}).periodic, true);
  EXPECT_EQ(test::code_of([&] { hidden_voxels(phases_of(h), {0}); }), "no-such-phase");
  EXPECT_EQ(test::code_of([&] { hidden_voxels(phases_of(h), {1, 2}); }), "all-hidden");
  Volume other = phases_of(h);
  other.grids = {
      dense_grid<openvdb::FloatGrid>("density", h.size, 0.25, {}, [](std::size_t) { return 1.0f; })};
  EXPECT_EQ(test::code_of([&] { hidden_voxels(other, {0}); }), "no-such-grid");
}

TEST(HiddenPhases, TheNodeRefusesWhatItCannotHide) {
  const auto render = [&](const HiddenVoxels& h, const std::string& hide, const std::string& mode) {
    Volume volume = phases_of(h);
    if (!h.periodic) {
      volume.resolution = Vec3i::Zero();
      volume.extent = h.size;
    }
    return test::code_of([&] {
      test::run_node("RenderSolid", {{"volume", Value::of(volume)}},
                     {{"hide", hide}, {"mode", mode}, {"width", "24"}, {"height", "24"}, {"samples", "2"}});
    });
  };
  const HiddenVoxels balls = hidden_balls(true);
  EXPECT_EQ(render(balls, "[2, 2]", "block"), "");
  EXPECT_EQ(render(balls, "[2]", "knot"), "");
  EXPECT_EQ(render(balls, "[7]", "block"), "no-such-phase");
  EXPECT_EQ(render(hidden_balls(false), "[2]", "cube"), "");
  EXPECT_EQ(render(hidden_balls(false), "[2]", "knot"), "bad-value");
  HiddenVoxels speck{kSize, true, std::vector<std::uint8_t>(voxels_in(kSize), 0)};
  speck.in[1000] = 1;
  EXPECT_EQ(render(speck, "[2]", "block"), "no-surface");
  EXPECT_EQ(render(speck, "[1]", "block"), "no-surface");
}

TEST(HiddenPhases, WallsHaveNoColorOfWhatIsHidden) {
  const HiddenVoxels h = hidden_balls(true);
  ColorField field = ColorField::of(phases_of(h));  // 1: 0.475, 2: 0.9
  field.cover(h);
  for (int k = 0; k < 2000; ++k) {
    Random r(5, 6, k);
    const Vec3f at(static_cast<float>(r.uniform(0, kSize.x())), static_cast<float>(r.uniform(0, kSize.y())),
                   static_cast<float>(r.uniform(0, kSize.z())));
    const Vec3i voxel = at.cast<int>().cwiseMin(kSize - Vec3i::Ones());
    const auto [hidden, all] = hidden_around(h, voxel);
    if (hidden < all) {
      EXPECT_NEAR(field.sharp(at).x(), 0.475f, 0.01f);
    }
  }
}

}  // namespace
}  // namespace terrazzo
