// Bodies with holes compared with the closed form of a block minus balls.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"
#include "nodes/common/stereology/shape_measures.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace carving;

class Gray : public Paint {
 public:
  Vec3f at(const Vec3f&, const Vec3f&, bool) const override { return Vec3f::Constant(0.5f); }
  Vec3f period() const override { return Vec3f::Ones(); }
};

// One ball in the middle and one across the corners of the box.
struct Cheese {
  Shapes shapes;
  Particles p;
  Cheese() {
    shapes.shapes = {measure_shape("ball", test::sphere_mesh(5))};
    p.box = Vec3::Constant(10);
    p.resize(2);
    p.position = {Vec3(5, 5, 5), Vec3(0.5, 9.5, 0.2)};
    p.scale = {4, 6};
    p.voids = {1, 1};
  }
  double repeat = 1;
  Placement placement;
  Voids voids() const { return {&p, &shapes, repeat, placement}; }
  bool in_void(const Vec3& world) const {
    const Vec3 mm = placement.turn.cast<double>() * world * 10 * repeat + 10 * placement.shift.cast<double>();
    for (int i = 0; i < 2; ++i) {
      Vec3 d = mm - p.position[i];
      for (int a = 0; a < 3; ++a) d[a] -= 10 * std::round(d[a] / 10);
      if (d.norm() < p.scale[i] / 2) return true;
    }
    return false;
  }
};

// By small steps: the first point of material along the ray.
std::optional<double> march(const Cheese& c, const Vec3& o, const Vec3& d, double cut) {
  const auto removed = [&](const Vec3& p) { return p.x() > 1 - cut && p.y() < cut && p.z() > 1 - cut; };

  for (double t = 0; t < 4; t += 2e-4) {
    const Vec3 p = o + t * d;
    if ((p.array() > 0).all() && (p.array() < 1).all() && !removed(p) && !c.in_void(p)) return t;
  }
  return {};
}

void expect_as_marched(const Cheese& c, double cut = 0) {
  const Gray paint;
  const auto solid = block_solid(paint, cut, 0.008, c.voids());
  int seen = 0, grazed = 0, walls = 0;
  for (std::uint64_t k = 0; k < 500; ++k) {
    Random r(6, 2, k);
    const bool from_within = k % 3 == 0;
    Vec3 d(r.normal(), r.normal(), r.normal());
    d.normalize();
    Vec3 target(r.uniform(), r.uniform(), r.uniform());
    Vec3 o = target - 2 * d;
    if (from_within) {
      if (!c.in_void(target)) continue;
      o = target;
    }
    const auto truth = march(c, o, d, cut);
    SurfacePoint s;
    const bool found = solid->nearest(o.cast<float>(), d.cast<float>(), s);
    EXPECT_EQ(solid->any(o.cast<float>(), d.cast<float>()), found);
    if (truth.has_value() != found) {
      ++grazed;  // missed by the steps
      continue;
    }
    if (!found) continue;
    if (std::abs((s.position.cast<double>() - o).dot(d) - *truth) > 4e-3) {
      ++grazed;
      continue;
    }
    ++seen;
    EXPECT_LT(s.face.dot(d.cast<float>()), 0);  // towards the viewer
    const bool outer = (s.position.array() < 1e-4f).any() || (s.position.array() > 1 - 1e-4f).any();
    EXPECT_TRUE(!s.open || outer);
    walls += !outer;
  }
  EXPECT_GT(seen, 150);
  EXPECT_GT(walls, 40);
  EXPECT_LE(grazed, 3);
}

TEST(Hollows, RaysMeetWhatMarchingMeets) {
  expect_as_marched({});
  expect_as_marched({}, 0.5);
}

TEST(Hollows, TheMaterialsLieTurnsAndRepeatsItsHoles) {
  Cheese c;
  c.repeat = 1.7;
  c.placement = Placement::of(Vec3(20, 35, -70), Vec3(0.3, 0, 0.9));
  expect_as_marched(c);
}

TEST(Hollows, ABodyWithinOneVoidIsNotThere) {
  Cheese c;
  c.p.position[0] = Vec3(1, 1, 1);
  c.p.scale[0] = 9;
  c.p.voids = {1, 0};
  c.repeat = 0.2;
  const Gray paint;
  const auto solid = block_solid(paint, 0, 0.008, c.voids());
  SurfacePoint s;
  EXPECT_FALSE(solid->nearest(Vec3f(0.5f, 0.5f, 3), Vec3f(0, 0, -1), s));
}

TEST(Hollows, WithoutVoidsNothingChanges) {
  Cheese c;
  c.p.voids.clear();
  const Gray paint;
  const auto solid = block_solid(paint, 0.5, 0.008, c.voids()), plain = block_solid(paint);
  for (std::uint64_t k = 0; k < 200; ++k) {
    Random r(7, 2, k);
    const Vec3f d = Vec3f(float(r.normal()), float(r.normal()), float(r.normal())).normalized();
    const Vec3f o = Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform())) - 2 * d;
    SurfacePoint a, b;
    const bool hit = solid->nearest(o, d, a);
    ASSERT_EQ(hit, plain->nearest(o, d, b));
    if (hit) {
      EXPECT_EQ(a.position, b.position);
    }
  }
}

TEST(Hollows, TooManyAreRefused) {
  Cheese c;
  c.repeat = 2000;
  const Gray paint;
  EXPECT_EQ(test::code_of([&] { block_solid(paint, 0, 0.008, c.voids()); }), "too-many-particles");
}

}  // namespace
}  // namespace terrazzo
