#include "nodes/shapes/shape_estimate/subdivide.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <memory>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::shape_estimate {

namespace {

namespace osd = OpenSubdiv;

struct Point {
  Vec3 p = Vec3::Zero();
  void Clear(void* = nullptr) { p.setZero(); }
  void AddWithWeight(const Point& q, double w) { p += w * q.p; }
};

class Surface {
 public:
  Surface(const ControlMesh& mesh, int level) : level_(level) {
    std::vector<int> counts, corners, pairs;
    for (const auto& f : mesh.faces) {
      counts.push_back(count_of(f));
      corners.insert(corners.end(), f.begin(), f.end());
    }
    for (const auto& e : mesh.crease_edges) pairs.insert(pairs.end(), e.begin(), e.end());
    osd::Far::TopologyDescriptor d;
    d.numVertices = mesh.vertices.size();
    d.numFaces = mesh.faces.size();
    d.numVertsPerFace = counts.data();
    d.vertIndicesPerFace = corners.data();
    d.numCreases = mesh.crease_edges.size();
    d.creaseVertexIndexPairs = pairs.data();
    d.creaseWeights = mesh.crease_sharpness.data();
    using Factory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
    refiner_.reset(Factory::Create(d, Factory::Options(osd::Sdc::SCHEME_CATMARK, osd::Sdc::Options())));
    if (!refiner_)
      throw Error("bad-control-mesh", "the control mesh is not a surface that can be subdivided");
    // At least one level, because limit points require a refined mesh.
    osd::Far::TopologyRefiner::UniformOptions options(std::max(1, level));
    options.fullTopologyInLastLevel = true;
    refiner_->RefineUniform(options);
  }

  // Limit positions of the vertices of the last level.
  std::vector<Point> limit(const std::vector<Point>& control) const {
    const osd::Far::PrimvarRefinerReal<double> primvars(*refiner_);
    std::vector<Point> at = control;
    for (int l = 1; l <= refiner_->GetMaxLevel(); ++l) {
      std::vector<Point> next(refiner_->GetLevel(l).GetNumVertices());
      primvars.Interpolate(l, at, next);
      at = std::move(next);
    }
    std::vector<Point> out(at.size());
    primvars.Limit(at, out);
    return out;
  }

  // The vertex of the last level that descends from a control vertex.
  int descendant(int v) const {
    for (int l = 0; l < refiner_->GetMaxLevel(); ++l) v = refiner_->GetLevel(l).GetVertexChildVertex(v);
    return v;
  }

  Mesh tessellation(const std::vector<Point>& control) const {
    const auto points = limit(control);
    Mesh mesh;
    const auto& last = refiner_->GetLevel(level_);
    for (int v = 0; v < last.GetNumVertices(); ++v)
      mesh.vertices.push_back(points[level_ == 0 ? descendant(v) : v].p);
    for (int f = 0; f < last.GetNumFaces(); ++f) {
      const auto c = last.GetFaceVertices(f);
      if (c.size() == 3) {
        mesh.triangles.push_back({c[0], c[1], c[2]});
        continue;
      }
      const bool first = (mesh.vertices[c[0]] - mesh.vertices[c[2]]).squaredNorm() <=
                         (mesh.vertices[c[1]] - mesh.vertices[c[3]]).squaredNorm();
      const int k = first ? 0 : 1;
      mesh.triangles.push_back({c[k], c[k + 1], c[k + 2]});
      mesh.triangles.push_back({c[k], c[k + 2], c[(k + 3) % 4]});
    }
    return mesh;
  }

 private:
  int level_;
  std::unique_ptr<osd::Far::TopologyRefiner> refiner_;
};

}  // namespace

Mesh interpolating_surface(const ControlMesh& mesh, int level, int iterations, const Work& work) {
  std::vector<Point> control;
  for (const auto& v : mesh.vertices) control.push_back({v});
  // One level is enough for the limits of the control vertices, unless creases fade after more levels.
  const Surface probe(mesh, 1), surface(mesh, level);
  const Surface& fit = level > 1 && !mesh.crease_edges.empty() ? surface : probe;
  for (int i = 0; i < iterations; ++i) {
    work.check();
    const auto at = fit.limit(control);
    for (std::size_t v = 0; v < control.size(); ++v)
      control[v].p += mesh.vertices[v] - at[fit.descendant(v)].p;
  }
  return surface.tessellation(control);
}

}  // namespace terrazzo::shape_estimate
