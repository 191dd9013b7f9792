#include <Eigen/Sparse>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/stereology/outline_features.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/rays.h"
#include "nodes/shapes/shape_estimate/relief.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {
namespace {

using std::numbers::pi;

constexpr std::uint64_t kFacetStream = 0x66616365;

// A disc of triangles within an outline: the middle, and rings that are closer to each other at the rim,
// where the surface is steep.
struct Disc {
  int rings = 0, columns = 0;
  std::vector<Vec2> points;  // the middle, then ring by ring outwards
  std::vector<Triangle> triangles;

  int at(int ring, int column) const { return 1 + (ring - 1) * columns + column % columns; }
  int inner() const { return 1 + (rings - 1) * columns; }  // number of points within the rim
};

Disc disc_within(const std::vector<double>& radii, int rings) {
  Disc disc;
  disc.rings = rings;
  disc.columns = count_of(radii);
  disc.points.push_back(Vec2::Zero());
  const Loop rim = loop_of_radii(radii);
  for (int i = 1; i <= rings; ++i)
    for (const Vec2& p : rim) disc.points.push_back(std::sin(pi / 2 * i / rings) * p);
  for (int c = 0; c < disc.columns; ++c) {
    disc.triangles.push_back({0, disc.at(1, c), disc.at(1, c + 1)});
    for (int i = 1; i < rings; ++i) {
      disc.triangles.push_back({disc.at(i, c), disc.at(i + 1, c), disc.at(i + 1, c + 1)});
      disc.triangles.push_back({disc.at(i, c), disc.at(i + 1, c + 1), disc.at(i, c + 1)});
    }
  }
  return disc;
}

// Solves ∇²u = −1 within the rim and u = 0 on it with linear finite elements.
Eigen::VectorXd stress_function(const Disc& disc) {
  const int n = disc.inner();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(n);
  for (const Triangle& t : disc.triangles) {
    const Vec2 edge[3] = {disc.points[t[2]] - disc.points[t[1]], disc.points[t[0]] - disc.points[t[2]],
                          disc.points[t[1]] - disc.points[t[0]]};
    const double area = (edge[0].x() * edge[1].y() - edge[0].y() * edge[1].x()) / 2;
    for (int i = 0; i < 3; ++i) {
      if (t[i] >= n) continue;
      load[t[i]] += area / 3;
      for (int j = 0; j < 3; ++j)
        if (t[j] < n) entries.emplace_back(t[i], t[j], edge[i].dot(edge[j]) / (4 * area));
    }
  }
  Eigen::SparseMatrix<double> stiffness(n, n);
  stiffness.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(stiffness);
  return solver.solve(load);
}

// A plane that cuts a worn face off the ball of radius 1.
struct Face {
  Vec3 normal;
  double distance;  // from the middle
};

// Faces spread over the upper half of the ball. A face at the distance 1 − h reduces radii by 0 to h.
std::vector<Face> worn_faces(double relief, Random& random) {
  constexpr int kFaces = 7;
  // The radii of a ball with such faces have this multiple of the relief as their standard deviation.
  constexpr double kDepth = 2.6;
  constexpr double kGolden = 2.399963229728653;
  const double start = random.uniform(0, 2 * pi);
  std::vector<Face> faces;
  for (int k = 0; k < kFaces; ++k) {
    const double z = 1 - 0.8 * (k + random.uniform()) / kFaces;
    const double azimuth = start + k * kGolden + random.uniform(-0.4, 0.4);
    const double across = std::sqrt(1 - z * z);
    faces.push_back({Vec3(across * std::cos(azimuth), across * std::sin(azimuth), z),
                     1 - kDepth * relief * (0.5 + random.uniform())});
  }
  return faces;
}

// The smaller of two heights, with a round edge.
double smooth_min(double a, double b, double rounding) {
  if (!(rounding > 0)) return std::min(a, b);
  const double h = std::max(rounding - std::abs(a - b), 0.0) / rounding;
  return std::min(a, b) - h * h * rounding / 4;
}

// Height of one side, relative to the middle's without faces.
std::vector<double> heights_of(const Disc& disc, const Eigen::VectorXd& dome, const Vec2& axes, double relief,
                               Random random) {
  constexpr double kLeast = 0.4;  // of the dome: faces never reach the silhouette
  const std::vector<Face> faces = relief > 0 ? worn_faces(relief, random) : std::vector<Face>();
  std::vector<double> out;
  for (int i = 0; i < disc.inner(); ++i) {
    const Vec2 p = disc.points[i].cwiseQuotient(axes);
    double z = dome[i];
    for (const Face& f : faces)
      z = smooth_min(z, (f.distance - f.normal.head<2>().dot(p)) / f.normal.z(), relief);
    out.push_back(std::max(z, kLeast * dome[i]));
  }
  return out;
}

Mesh body_of(const Disc& disc, const std::vector<double>& upper, const std::vector<double>& lower,
             double height) {
  Mesh mesh;
  const int n = disc.inner();
  for (std::size_t i = 0; i < disc.points.size(); ++i) {
    const double z = count_of(upper) > static_cast<int>(i) ? height * upper[i] : 0;
    mesh.vertices.emplace_back(disc.points[i].x(), disc.points[i].y(), z);
  }
  const int first = count_of(mesh.vertices);
  for (int i = 0; i < n; ++i)
    mesh.vertices.emplace_back(disc.points[i].x(), disc.points[i].y(), -height * lower[i]);
  const auto below = [&](int i) { return i < n ? first + i : i; };
  mesh.triangles = disc.triangles;
  for (const Triangle& t : disc.triangles) mesh.triangles.push_back({below(t[0]), below(t[2]), below(t[1])});
  return mesh;
}

// The outline in `columns` directions about its center, or the ellipse of the same area and moments.
std::vector<double> radii_of(const Outline& o, const Vec2& axes, bool round, int columns) {
  constexpr double kLeast = 0.05;  // of the axes, where the center is outside
  std::vector<double> radii(columns, kLeast * axes.minCoeff());
  const auto add = [&](const std::vector<Vec2>& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) raise_radii(radii, loop[i], loop[(i + 1) % loop.size()]);
  };
  if (!round) {
    add(o.points);
    return radii;
  }
  Loop ellipse;
  for (int k = 0; k < 4 * columns; ++k) {
    const double phi = 2 * pi * k / (4 * columns);
    ellipse.emplace_back(axes.x() * std::cos(phi), axes.y() * std::sin(phi));
  }
  add(ellipse);
  return radii;
}

}  // namespace

Estimate inflation(const EstimateRequest& request, const Work& work) {
  work.check();
  const Outline& o = request.chosen[0];
  const int fine = 1 << request.subdivision;
  const double aspect = outline_features(o.points)[OutlineFeature::Aspect];
  const double longer = std::sqrt(o.area / (pi * aspect));
  const Vec2 axes(longer, longer * aspect);
  const bool round = request.relief < kRound;
  const Disc disc = disc_within(radii_of(o, axes, round, 32 * fine), 6 * fine);
  Eigen::VectorXd dome = stress_function(disc);
  // Thin triangles at sharp tips can give values below 0, which would let both sides meet.
  constexpr double kLeast = 1e-3;
  dome = (dome / dome.maxCoeff()).cwiseMax(kLeast).cwiseSqrt();
  const double relief = round ? 0 : request.relief;
  const auto side = [&](int k) {
    return heights_of(disc, dome, axes, relief, Random(request.seed, kFacetStream, 2 * request.index + k));
  };
  Estimate out;
  out.mesh = body_of(disc, side(0), side(1), axes.y());
  return out;
}

}  // namespace terrazzo::shape_estimate
