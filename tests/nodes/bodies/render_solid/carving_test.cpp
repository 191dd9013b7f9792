// Bodies carved from a packing: every point has the color of the particle that contains it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "nodes/bodies/carving/body.h"
#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/forms.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/bodies/render_solid/render.h"
#include "nodes/bodies/render_solid/tone.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/image.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace carving;
using namespace render_solid;

// A few rotated cubes of 2 to 3 mm in a box of 10 × 8 × 12 mm; they may overlap.
Particles scattered(std::uint64_t seed, int n) {
  Particles p;
  p.box = Vec3(10, 8, 12);
  p.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    Random r(seed, 9, static_cast<std::uint64_t>(i));
    p.position[i] = Vec3(r.uniform(0, 10), r.uniform(0, 8), r.uniform(0, 12));
    p.orientation[i] = Quat(r.normal(), r.normal(), r.normal(), r.normal()).normalized();
    p.scale[i] = r.uniform(2, 3);
    p.color[i] = Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform()));
  }
  p.binder_color = Vec3f(0.9f, 0.9f, 0.9f);
  return p;
}

// Embree would end the process.
TEST(Carving, CoordinatesThatCannotBeSquaredAreRefused) {
  for (const double far : {1e16, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    Shapes shapes;
    shapes.shapes = {measure_shape("cube", test::cube_mesh())};
    Particles p = scattered(1, 3);
    shapes.shapes[0].mesh.vertices[2].y() = far;
    EXPECT_EQ(test::code_of([&] { ParticleIndex(p, shapes); }), "bad-number") << far;
  }
}

// Rays start outside the block, in its cut, or inside. Some are parallel to faces.
TEST(Carving, RaysMeetABlockWhereTheyEnterOrLeaveIt) {
  const Vec3f size(1, 0.7f, 0.9f);
  for (const float cut : {0.0f, 0.4f}) {
    const auto block = block_body(size, cut, 0.01);
    const auto inside = [&](const Vec3f& p) {
      const bool in_box = p.minCoeff() > 0 && (size - p).minCoeff() > 0;
      return in_box &&
             !(p.x() > size.x() * (1 - cut) && p.y() < size.y() * cut && p.z() > size.z() * (1 - cut));
    };
    int hits = 0, misses = 0, inner = 0;
    for (std::uint64_t k = 0; k < 4000; ++k) {
      Random r(7, 1, k);
      Vec3f origin, direction;
      for (int a = 0; a < 3; ++a) {
        origin[a] = static_cast<float>(r.uniform(-0.5, 1.5));
        direction[a] = r.below(8) == 0 ? 0.0f : static_cast<float>(r.normal());
      }
      if (direction.norm() == 0) continue;
      direction.normalize();
      SurfacePoint s;
      float at = 4;
      const bool met = block->meet(origin, direction, s, at);
      EXPECT_EQ(block->any(origin, direction), met);
      ++(met ? hits : misses);
      for (int i = 1; i < 100; ++i) {
        const Vec3f p = origin + (0.01f * float(i) * at) * direction;
        ASSERT_EQ(inside(p), inside(origin)) << "ray " << k << ", step " << i;
      }
      if (!met) continue;
      ASSERT_LT((s.position - (origin + at * direction)).norm(), 1e-5f);
      EXPECT_EQ(s.face.dot(direction) > 0, inside(origin)) << k;
      EXPECT_EQ(s.face.norm(), 1);
      const bool outer = (s.position.array() == 0).any() || (s.position.array() == size.array()).any();
      EXPECT_EQ(s.open, outer) << k;
      inner += !outer;
      EXPECT_GT(s.normal.dot(s.face), 0.4f);
      const Vec3f beyond = s.position + 1e-5f * direction / std::abs(direction.dot(s.face));
      EXPECT_NE(inside(beyond), inside(origin)) << k;
    }
    EXPECT_GT(hits, 500);
    EXPECT_GT(misses, 1000);
    EXPECT_EQ(inner > 20, cut > 0);
  }
}

TEST(Carving, TheIndexFindsTheParticleThatHoldsAPoint) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Particles p = scattered(seed, 12);
    const ParticleIndex index(p, shapes);
    int held = 0;
    for (std::uint64_t k = 0; k < 4000; ++k) {
      Random r(seed, 3, k);
      const Vec3 at(r.uniform(-20, 30), r.uniform(-20, 30), r.uniform(-20, 30));
      bool near_face = false;
      std::vector<int> truth;
      for (int i = 0; i < 12; ++i) {
        Vec3 d = at - p.position[i];
        for (int a = 0; a < 3; ++a) d[a] -= p.box[a] * std::round(d[a] / p.box[a]);
        const double m = (p.orientation[i].conjugate() * d / p.scale[i]).cwiseAbs().maxCoeff();
        near_face = near_face || std::abs(m - 0.5) < 1e-3;
        if (m < 0.5) truth.push_back(i);
      }
      if (near_face) continue;
      const int found = index.at(at.cast<float>());
      if (truth.empty())
        ASSERT_EQ(found, -1);
      else
        ASSERT_NE(std::find(truth.begin(), truth.end(), found), truth.end());
      held += !truth.empty();
    }
    EXPECT_GT(held, 200);
  }
}

TEST(Carving, ParticlesPaintRepeatsAndTurns) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  const Particles p = scattered(5, 12);
  const auto paint = particle_paint(p, shapes, 2);
  const auto turned = particle_paint(p, shapes, 2, Placement::of(Vec3(0, 0, 90), Vec3(1, 0, 0)));
  EXPECT_LT((paint->period() - Vec3f(10, 8, 12) / 12).norm(), 1e-6);
  int same = 0, turns = 0;
  for (std::uint64_t k = 0; k < 500; ++k) {
    Random r(5, 4, k);
    const Vec3f at(float(r.uniform()), float(r.uniform()), float(r.uniform()));
    // Two periods of the longest edge, 12 mm, in one unit.
    const Vec3f period = Vec3f(10, 8, 12) / 24;
    same += paint->at(at, Vec3f::Zero(), true) == paint->at(at + period, Vec3f::Zero(), true);
    turns +=
        turned->at(Vec3f(at.y(), -at.x(), at.z()), Vec3f::Zero(), true) == paint->at(at, Vec3f::Zero(), true);
  }
  EXPECT_GE(turns, 497);
  EXPECT_GE(same, 497);  // rounding may decide at a surface
}

TEST(Carving, AnObliqueFaceDoesNotRepeat) {
  std::vector<Vec3f> colors;
  for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i) {
    Random r(1, 1, i);
    colors.push_back(Vec3f::Constant(float(r.uniform())));
  }
  const ColorField field(Vec3i(16, 16, 16), colors);
  const auto straight = field_paint(field, 4),
             oblique = field_paint(field, 4, Placement::of(Vec3(20, 35, 10), Vec3::Zero()));
  double a = 0, b = 0;
  for (std::uint64_t k = 0; k < 400; ++k) {
    Random r(2, 2, k);
    const Vec3f at(float(r.uniform(0, 0.7)), float(r.uniform(0, 0.7)), 1), next = at + Vec3f(0.25f, 0, 0);
    a += std::abs(straight->at(at, Vec3f::UnitZ(), true).x() - straight->at(next, Vec3f::UnitZ(), true).x());
    b += std::abs(oblique->at(at, Vec3f::UnitZ(), true).x() - oblique->at(next, Vec3f::UnitZ(), true).x());
  }
  EXPECT_LT(a / 400, 1e-3);
  EXPECT_GT(b / 400, 0.1);
}

TEST(Carving, FormsAreClosedAndStand) {
  for (const Shape& s : {vase_form(), knot_form()}) {
    EXPECT_TRUE(mesh_faults(s.mesh).empty()) << s.name << ": " << mesh_faults(s.mesh).front();
    EXPECT_GT(mesh_volume(s.mesh), 0.02) << s.name;
    Eigen::AlignedBox3d box;
    for (const Vec3& v : s.mesh.vertices) box.extend(v);
    EXPECT_NEAR(box.min().z(), 0, 1e-12);
    EXPECT_NEAR(box.sizes().maxCoeff(), 1, 1e-12);
  }
}

// A particle cut by a body's edge shows on both faces: color is a single function of space.
TEST(Carving, ParticlesContinueAcrossEdges) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  const auto paint = particle_paint(scattered(7, 14), shapes);
  const auto solid = block_solid(*paint, 0.5, 0);
  const Vec3f size = paint->period();
  int differs = 0, total = 0;
  for (int i = 1; i < 200; ++i) {
    const float t = float(i) / 200 * size.z();
    // Just beside the edge between +x and +y, on either face.
    SurfacePoint a, b;
    const float e = 1e-4f;
    if (!solid->nearest(Vec3f(2, size.y() - e, t), Vec3f(-1, 0, 0), a, true)) continue;
    if (!solid->nearest(Vec3f(size.x() - e, 2, t), Vec3f(0, -1, 0), b, true)) continue;
    ++total;
    differs += (a.albedo - b.albedo).norm() > 1e-6;
  }
  EXPECT_GT(total, 150);
  EXPECT_LE(differs, 4);
}

TEST(Carving, AFractureKeepsWholeParticlesAndLeavesSockets) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  Particles p;
  p.box = Vec3(10, 10, 10);
  p.resize(2);
  p.position = {Vec3(3, 5, 4.8), Vec3(7, 5, 5.2)};  // on either side of the plane at 5 mm
  p.scale = {2, 2};
  p.color = {Vec3f(0.8f, 0.1f, 0.1f), Vec3f(0.1f, 0.1f, 0.8f)};
  p.binder_color = Vec3f::Constant(0.5f);
  const auto paint = particle_paint(p, shapes);
  const auto solid = fracture_solid(*paint, p, shapes, 0.5, 0, 1);
  SurfacePoint s;
  const auto from_above = [&](float x, float y) {
    EXPECT_TRUE(solid->nearest(Vec3f(x, y, 3), Vec3f(0, 0, -1), s, true));
    return s;
  };
  from_above(0.3f, 0.5f);  // a cube from 3.8 to 5.8 mm sticks out
  EXPECT_NEAR(s.position.z(), 0.58f, 1e-5);
  EXPECT_EQ(s.albedo, p.color[0]);
  from_above(0.7f, 0.5f);  // a socket, down to 4.2 mm
  EXPECT_NEAR(s.position.z(), 0.42f, 1e-5);
  EXPECT_NEAR(s.face.z(), 1, 1e-5);
  EXPECT_EQ(s.albedo, p.binder_color);
  from_above(0.5f, 0.2f);
  EXPECT_NEAR(s.position.z(), 0.5f, 1e-5);
  // From the side, outside all cut particles: binder. Then from inside the socket to its wall.
  ASSERT_TRUE(solid->nearest(Vec3f(-1, 0.5f, 0.2f), Vec3f(1, 0, 0), s, true));
  EXPECT_NEAR(s.position.x(), 0, 1e-6);
  EXPECT_EQ(s.face, Vec3f(-1, 0, 0));
  ASSERT_TRUE(solid->nearest(Vec3f(0.7f, 0.5f, 0.46f), Vec3f(1, 0, 0), s, true));
  EXPECT_NEAR(s.position.x(), 0.8f, 1e-5);
  EXPECT_LT(s.face.x(), -0.9f);
  // Above the face a ray hits only particles that stick out.
  EXPECT_FALSE(solid->any(Vec3f(-1, 0.1f, 0.55f), Vec3f(1, 0, 0)));
  EXPECT_TRUE(solid->any(Vec3f(-1, 0.5f, 0.55f), Vec3f(1, 0, 0)));
}

TEST(Carving, AcesToneIsNeutralAndRises) {
  Image ramp(40, 1, 1, 1);
  for (int i = 0; i < 40; ++i) ramp.at(i, 0) = Vec3f::Constant(0.03f * float(i * i) / 10);
  Tone(ToneKind::Aces).apply(ramp);
  for (int i = 0; i < 40; ++i) {
    const Vec3f v = ramp.at(i, 0);
    EXPECT_LT(v.maxCoeff() - v.minCoeff(), 0.01f) << "gray stays gray";
    EXPECT_LE(v.maxCoeff(), 1);
    EXPECT_GE(v.x(), i ? ramp.at(i - 1, 0).x() - 1e-5f : 0);
  }
  EXPECT_GT(ramp.at(39, 0).x(), 0.8f);
}

TEST(Carving, FramesTurnAndModesRun) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  const std::multimap<std::string, Value> in = {{"particles", Value::of(scattered(3, 8))},
                                                {"shapes", Value::of(shapes)}};
  const std::map<std::string, std::string> small = {{"width", "32"}, {"height", "24"}, {"samples", "2"}};
  for (const std::string mode : {"vase", "knot", "fracture", "block"}) {
    auto p = small;
    p["mode"] = mode, p["frames"] = "2";
    const auto image = test::run_node("RenderSolid", in, p).output<Image>("image");
    ASSERT_EQ(image.sections, 2) << mode;
    p["frames"] = "1", p["azimuth"] = "139";
    const auto second = test::run_node("RenderSolid", in, p).output<Image>("image");
    double difference = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 32; ++x) difference += (image.at(x, y, 1) - second.at(x, y)).norm();
    EXPECT_LT(difference / (24 * 32), 1e-3) << mode;
  }
}

}  // namespace
}  // namespace terrazzo
