#include "nodes/shapes/shape/stones.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/common/geometry/directions.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape/solids.h"
#include "runtime/random.h"

namespace terrazzo::shape {

namespace {

using std::numbers::pi;

enum StoneStream : std::uint64_t { kStoneField = 121, kSides, kBend, kAxes };

// Scales radii by exp of a random field over directions, with wavelengths from `shortest` to `longest`
// (relative to the radius) and standard deviation `sd`. Points stay on their rays, so nothing folds.
void swell(Mesh& mesh, Random r, double sd, double shortest, double longest) {
  constexpr int kWaves = 32;
  std::vector<Vec3> wave;
  std::vector<double> phase, weight;
  double power = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double length = std::exp(r.uniform(std::log(shortest), std::log(longest)));
    wave.push_back(random_direction(r) * (2 * pi / length));
    phase.push_back(r.uniform(0, 2 * pi));
    weight.push_back(length);
    power += length * length / 2;
  }
  std::vector<double> f;
  double mean = 0;
  for (const auto& v : mesh.vertices) {
    const Vec3 u = v.normalized();
    double sum = 0;
    for (int i = 0; i < kWaves; ++i) sum += weight[i] * std::cos(wave[i].dot(u) + phase[i]);
    f.push_back(sd * sum / std::sqrt(power));
    mean += f.back() / mesh.vertices.size();
  }
  for (std::size_t i = 0; i < f.size(); ++i) mesh.vertices[i] *= std::exp(f[i] - mean);
}

// Flattens the parts beyond each of `sides` planes to a hundredth of their height.
void flatten(Mesh& mesh, Random r, int sides, double from, double to) {
  std::vector<Vec3> normals;
  for (int tries = 0; count_of(normals) < sides && tries < 1000; ++tries) {
    const Vec3 n = random_direction(r);
    if (std::all_of(normals.begin(), normals.end(), [&](const Vec3& m) { return m.dot(n) < 0.5; }))
      normals.push_back(n);
  }
  for (const Vec3& n : normals) {
    double high = 0;
    for (const auto& v : mesh.vertices) high = std::max(high, n.dot(v));
    const double at = high * r.uniform(from, to);
    for (auto& v : mesh.vertices) v -= 0.99 * std::max(0.0, n.dot(v) - at) * n;
  }
}

// Bends the x axis into an arc of `turn` radians.
void bend(Mesh& mesh, double turn) {
  double half = 0;
  for (const auto& v : mesh.vertices) half = std::max(half, std::abs(v.x()));
  const double radius = 2 * half / turn;
  for (auto& v : mesh.vertices) {
    const double a = v.x() / radius, reach = radius + v.y();
    v = {reach * std::sin(a), reach * std::cos(a) - radius, v.z()};
  }
}

}  // namespace

Mesh stone_mesh(const StoneOptions& o, const Work& work) {
  Mesh mesh = ellipsoid_mesh({2, 2, 2}, o.detail);
  const auto random = [&](StoneStream s) { return Random(o.seed, s, o.item); };
  Random a = random(kAxes);
  Vec3 axes = o.axes;
  for (int k = 0; k < 3; ++k) axes[k] *= a.uniform(0.85, 1.1);
  const auto stretch = [&] {
    for (auto& v : mesh.vertices) v = v.cwiseProduct(axes);
  };
  work.check();
  if (o.kind == SolidKind::Pebble) {
    axes = axes.cwiseProduct(Vec3(1.15, 1, 0.8));
    swell(mesh, random(kStoneField), 0.05, 1.8, 4);
    stretch();
  } else if (o.kind == SolidKind::Shard) {
    axes = axes.cwiseProduct(Vec3(1.7, 1, 0.8));
    swell(mesh, random(kStoneField), 0.05, 1.5, 4);
    flatten(mesh, random(kSides), 5, 0.72, 0.85);
    stretch();
  } else {
    // A lobed bar, thin enough that the bend does not fold its inner side.
    swell(mesh, random(kStoneField), 0.22, 0.9, 3);
    axes = axes.cwiseProduct(Vec3(2, 0.8, 0.9));
    stretch();
    bend(mesh, random(kBend).uniform(2.2, 2.8));
  }
  return mesh;
}

}  // namespace terrazzo::shape
