#include "nodes/shapes/shape_cage/shape_cage.h"

#include <fmt/format.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <memory>

#include "graph/diagnostic.h"
#include "graph/text/read_number.h"
#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/common/geometry/mesh/reduce.h"
#include "nodes/data/indices.h"

namespace terrazzo::shape_cage {
namespace {

namespace osd = OpenSubdiv;

struct Position {
  Vec3 p = Vec3::Zero();
  void Clear(void* = nullptr) { p.setZero(); }
  void AddWithWeight(const Position& q, double w) { p += w * q.p; }
};

// The weights of all control vertices in one point.
struct Weights {
  Eigen::VectorXd w;
  void Clear(void* = nullptr) { w.setZero(); }
  void AddWithWeight(const Weights& q, double by) { w += by * q.w; }
};

class Surface {
 public:
  Surface(const Mesh& control, int level) {
    const std::vector<int> counts(control.triangles.size(), 3);
    std::vector<int> corners;
    for (const Triangle& t : control.triangles) corners.insert(corners.end(), t.begin(), t.end());
    osd::Far::TopologyDescriptor d;
    d.numVertices = control.vertices.size();
    d.numFaces = control.triangles.size();
    d.numVertsPerFace = counts.data();
    d.vertIndicesPerFace = corners.data();
    using Factory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
    refiner_.reset(Factory::Create(d, Factory::Options(osd::Sdc::SCHEME_LOOP, osd::Sdc::Options())));
    if (!refiner_)
      throw Error("bad-control-mesh", "the control mesh is not a surface that can be subdivided");
    osd::Far::TopologyRefiner::UniformOptions options(level);
    options.fullTopologyInLastLevel = true;
    refiner_->RefineUniform(options);
  }

  // Limits of the last level's vertices. `blank` is a value to start from.
  template <class T>
  std::vector<T> limit(std::vector<T> at, const T& blank) const {
    const osd::Far::PrimvarRefinerReal<double> primvars(*refiner_);
    for (int l = 1; l <= refiner_->GetMaxLevel(); ++l) {
      std::vector<T> next(refiner_->GetLevel(l).GetNumVertices(), blank);
      primvars.Interpolate(l, at, next);
      at = std::move(next);
    }
    std::vector<T> out(at.size(), blank);
    primvars.Limit(at, out);
    return out;
  }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> out;
    const auto& last = refiner_->GetLevel(refiner_->GetMaxLevel());
    for (int f = 0; f < last.GetNumFaces(); ++f) {
      const auto c = last.GetFaceVertices(f);
      out.push_back({c[0], c[1], c[2]});
    }
    return out;
  }

 private:
  std::unique_ptr<osd::Far::TopologyRefiner> refiner_;
};

Vec3 closest_point(const Mesh& mesh, const AabbTree& tree, const Vec3& p) {
  Vec3 out = p;
  tree.visit_near(p, 1e300, [&](std::int32_t t, double best) {
    const Triangle& c = mesh.triangles[t];
    const auto corner = [&](int k) -> const Vec3& { return mesh.vertices[c[k]]; };
    int feature = 0;
    const Vec3 q = closest_point_on_triangle(p, corner(0), corner(1), corner(2), feature);
    const double d = (p - q).squaredNorm();
    if (d >= best) return best;
    out = q;
    return d;
  });
  return out;
}

}  // namespace

Mesh limit_surface(const Mesh& control, int level) {
  const Surface surface(control, level);
  std::vector<Position> at;
  for (const Vec3& v : control.vertices) at.push_back({v});
  Mesh out;
  for (const Position& p : surface.limit(std::move(at), Position())) out.vertices.push_back(p.p);
  out.triangles = surface.triangles();
  return out;
}

Cage fit_cage(const Mesh& mesh, int vertices, int iterations, const Work& work) {
  constexpr int kFitLevel = 2;      // 16 points for each triangle of the cage
  constexpr double kSteady = 1e-3;  // weight of staying in place, so that no vertex drifts
  Cage out;
  out.control = mesh;
  reduce_triangles(out.control, 2 * vertices - 4, work.part(0, 0.3));
  Mesh& control = out.control;

  const Eigen::Index n = control.vertices.size();
  const Surface surface(control, kFitLevel);
  std::vector<Weights> units;
  for (Eigen::Index v = 0; v < n; ++v) units.push_back({Eigen::VectorXd::Unit(n, v)});
  const auto rows = surface.limit(std::move(units), Weights{Eigen::VectorXd::Zero(n)});
  Eigen::MatrixXd limits(rows.size(), n);
  for (std::size_t r = 0; r < rows.size(); ++r) limits.row(r) = rows[r].w;
  const Eigen::MatrixXd square = limits.transpose() * limits + kSteady * Eigen::MatrixXd::Identity(n, n);
  const Eigen::LDLT<Eigen::MatrixXd> solver(square);

  const AabbTree tree(mesh);
  Eigen::MatrixXd at(n, 3);
  for (Eigen::Index v = 0; v < n; ++v) at.row(v) = control.vertices[v];
  for (int i = 0; i < iterations; ++i) {
    work.check();
    const Eigen::MatrixXd points = limits * at;
    Eigen::MatrixXd wanted(points.rows(), 3);
    for (Eigen::Index r = 0; r < points.rows(); ++r) wanted.row(r) = closest_point(mesh, tree, points.row(r));
    at = solver.solve(limits.transpose() * wanted + kSteady * at);
    work.progress(0.3 + 0.6 * (i + 1) / iterations);
  }
  for (Eigen::Index v = 0; v < n; ++v) control.vertices[v] = at.row(v);

  const Mesh fitted = limit_surface(control, kFitLevel);
  const AabbTree fitted_tree(fitted);
  double sum = 0, count = 0;
  const auto measure = [&](const Mesh& from, const Mesh& to, const AabbTree& to_tree) {
    for (const Vec3& p : from.vertices) {
      const double d = std::sqrt(squared_distance(to, to_tree, p, 1e300));
      sum += d;
      ++count;
      out.largest_error = std::max(out.largest_error, d);
    }
  };
  measure(fitted, mesh, tree);
  measure(mesh, fitted, fitted_tree);
  out.mean_error = sum / count;
  return out;
}

Move parse_move(const std::string& text) {
  Move m;
  std::string_view rest = text;
  std::array<double, 4> numbers{};
  bool read = true;
  for (double& number : numbers) {
    const auto v = take_number(rest);
    read =
        read && v && std::isfinite(*v) && (rest.empty() || std::isspace(static_cast<unsigned char>(rest[0])));
    number = v.value_or(0);
  }
  constexpr double kMostVertices = 2147483647;
  read = read && rest.find_first_not_of(" \t\r\n") == std::string_view::npos && numbers[0] >= 0 &&
         numbers[0] <= kMostVertices && numbers[0] == std::floor(numbers[0]);
  if (!read)
    throw Error("bad-move", fmt::format("'{}' is not a move", text),
                "write a vertex and how far it moves along x, y and z in mm, for example \"12 0.5 0 -1\"")
        .parameter("moves");
  m.vertex = static_cast<int>(numbers[0]);
  m.by = Vec3(numbers[1], numbers[2], numbers[3]);
  return m;
}

void move_vertices(Mesh& control, const std::vector<Move>& moves) {
  for (const Move& m : moves) {
    if (m.vertex >= count_of(control.vertices))
      throw Error("bad-move",
                  fmt::format("vertex {} is to be moved, but the cage has vertices 0 to {}", m.vertex,
                              control.vertices.size() - 1),
                  "choose a vertex of the node's table")
          .parameter("moves");
    control.vertices[m.vertex] += m.by;
  }
}

}  // namespace terrazzo::shape_cage
