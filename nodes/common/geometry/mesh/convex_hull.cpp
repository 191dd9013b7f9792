#include "nodes/common/geometry/mesh/convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

// Extended precision: the plane of a sliver as thin as the tolerance must be accurate to a tenth of it.
using Real = long double;
using Vec = Eigen::Matrix<Real, 3, 1>;

struct Face {
  std::array<int, 3> vertex;
  std::array<int, 3> neighbor;  // across the edge from vertex k to vertex k + 1
  Vec normal;
  Real offset = 0;
  std::vector<int> outside;  // points above this face, each in the list of one face only
  bool alive = true;
};

class Quickhull {
 public:
  Quickhull(const std::vector<Vec3>& points, Real tolerance) : points_(points), tolerance_(tolerance) {}

  // Returns nothing if the tolerance made the horizon of a point ambiguous; a larger tolerance may then
  // succeed.
  std::optional<Mesh> run() {
    start();
    for (std::size_t f = 0; f < faces_.size(); ++f)
      if (faces_[f].alive && !faces_[f].outside.empty() && !add_farthest(f)) return std::nullopt;
    return surface();
  }

 private:
  Vec at(int i) const { return points_[i].cast<Real>(); }
  Real height(const Face& f, int point) const { return f.normal.dot(at(point)) - f.offset; }

  int make_face(int a, int b, int c) {
    Face f;
    f.vertex = {a, b, c};
    f.neighbor = {-1, -1, -1};
    f.normal = (at(b) - at(a)).cross(at(c) - at(a));
    const Real n = f.normal.norm();
    if (n > 0) f.normal /= n;
    f.offset = f.normal.dot(at(a));
    faces_.push_back(std::move(f));
    return count_of(faces_) - 1;
  }

  // Chooses four points that span a large part of the volume.
  void start() {
    const int n = points_.size();
    const auto fail = [] {
      throw Error("flat-points", "the points of the body do not span a volume", "use a solid body");
    };
    if (n < 4) fail();
    const auto best = [&](auto&& measure) {
      int at = 0;
      Real most = -1;
      for (int i = 0; i < n; ++i)
        if (const Real m = measure(i); m > most) {
          most = m;
          at = i;
        }
      if (!(most > tolerance_)) fail();
      return at;
    };
    int lowest = 0;
    for (int i = 1; i < n; ++i)
      if (points_[i].x() < points_[lowest].x()) lowest = i;
    const int a = lowest;
    const int b = best([&](int i) { return (at(i) - at(a)).norm(); });
    const Vec axis = (at(b) - at(a)).normalized();
    const int c = best([&](int i) { return (at(i) - at(a)).cross(axis).norm(); });
    const Vec normal = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
    const int d = best([&](int i) { return std::abs((at(i) - at(a)).dot(normal)); });
    const bool above = (at(d) - at(a)).dot(normal) > 0;
    const std::array<int, 3> base = above ? std::array{a, c, b} : std::array{a, b, c};
    make_face(base[0], base[1], base[2]);
    for (int k = 0; k < 3; ++k) make_face(base[(k + 1) % 3], base[k], d);
    for (int k = 0; k < 3; ++k) {
      faces_[0].neighbor[k] = k + 1;
      faces_[k + 1].neighbor = {0, 1 + (k + 2) % 3, 1 + (k + 1) % 3};
    }
    std::vector<int> all(n);
    for (int i = 0; i < n; ++i) all[i] = i;
    distribute(all, 0);
  }

  // Assigns each point to the first face, starting at `first`, that it is above.
  void distribute(const std::vector<int>& points, std::size_t first) {
    for (int p : points)
      for (std::size_t f = first; f < faces_.size(); ++f)
        if (faces_[f].alive && height(faces_[f], p) > tolerance_) {
          faces_[f].outside.push_back(p);
          break;
        }
  }

  bool add_farthest(int seed) {
    int top = -1;
    Real most = -1;
    for (int p : faces_[seed].outside)
      if (const Real h = height(faces_[seed], p); h > most) {
        most = h;
        top = p;
      }

    // The faces visible from the point form one patch. Its boundary becomes the base of a cone.
    struct Rim {
      int from, to, face, side;  // the face beyond the edge, and its side there
    };
    std::vector<int> patch{seed}, orphans;
    std::vector<Rim> rim;
    faces_[seed].alive = false;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const int f = patch[i];
      for (int k = 0; k < 3; ++k) {
        const int g = faces_[f].neighbor[k];
        if (!faces_[g].alive) continue;
        if (height(faces_[g], top) > tolerance_) {
          faces_[g].alive = false;
          patch.push_back(g);
        }
      }
    }
    for (int f : patch) {
      for (int k = 0; k < 3; ++k) {
        const int g = faces_[f].neighbor[k];
        if (!faces_[g].alive) continue;
        const int from = faces_[f].vertex[k], to = faces_[f].vertex[(k + 1) % 3];
        int side = 0;
        while (faces_[g].vertex[side] != to) ++side;
        rim.push_back({from, to, g, side});
      }
      for (int p : faces_[f].outside)
        if (p != top) orphans.push_back(p);
      faces_[f].outside = {};
    }
    if (rim.size() < 3) return false;
    std::sort(rim.begin(), rim.end(), [](const Rim& a, const Rim& b) { return a.from < b.from; });
    for (std::size_t i = 1; i < rim.size(); ++i)
      if (rim[i].from == rim[i - 1].from) return false;

    const std::size_t first = faces_.size();
    for (const Rim& r : rim) {
      const int f = make_face(r.from, r.to, top);
      faces_[f].neighbor[0] = r.face;
      faces_[r.face].neighbor[r.side] = f;
    }
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const auto next =
          std::lower_bound(rim.begin(), rim.end(), rim[i].to, [](const Rim& r, int v) { return r.from < v; });
      if (next == rim.end() || next->from != rim[i].to) return false;
      const int g = first + (next - rim.begin());
      faces_[first + i].neighbor[1] = g;
      faces_[g].neighbor[2] = first + i;
    }
    distribute(orphans, first);
    return true;
  }

  Mesh surface() const {
    Mesh mesh;
    std::vector<std::int32_t> index(points_.size(), -1);
    for (const Face& f : faces_) {
      if (!f.alive) continue;
      Triangle t;
      for (int k = 0; k < 3; ++k) {
        auto& i = index[f.vertex[k]];
        if (i < 0) {
          i = mesh.vertices.size();
          mesh.vertices.push_back(points_[f.vertex[k]]);
        }
        t[k] = i;
      }
      mesh.triangles.push_back(t);
    }
    return mesh;
  }

  const std::vector<Vec3>& points_;
  Real tolerance_;
  std::vector<Face> faces_;
};

}  // namespace

Mesh convex_hull(const std::vector<Vec3>& points) {
  Vec3 lo = Vec3::Zero(), hi = Vec3::Zero();
  if (!points.empty()) lo = hi = points[0];
  for (const Vec3& p : points) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  const double extent = (hi - lo).norm();
  for (double tolerance = 1e-9; tolerance < 1e-3; tolerance *= 10)
    if (auto hull = Quickhull(points, tolerance * extent).run()) return *std::move(hull);
  throw Error("no-hull", "cannot compute the convex hull of the body", "simplify the mesh");
}

}  // namespace terrazzo
