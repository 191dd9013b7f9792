#include "nodes/common/geometry/mesh/reduce.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <vector>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<Traits>;

}  // namespace

void reduce_triangles(Mesh& mesh, std::size_t triangles, const Work& work) {
  if (mesh.triangles.size() <= triangles) return;
  HalfEdges edges;
  std::vector<HalfEdges::VertexHandle> corners;
  for (const Vec3& v : mesh.vertices) corners.push_back(edges.add_vertex({v.x(), v.y(), v.z()}));
  for (const Triangle& t : mesh.triangles)
    if (!edges.add_face(corners[t[0]], corners[t[1]], corners[t[2]]).is_valid())
      throw Error("bad-mesh", "surfaces touch along an edge or at a vertex, so the mesh cannot be reduced",
                  "separate the touching parts, or remove max_triangles");
  work.check();
  edges.request_face_normals();
  edges.update_face_normals();
  OpenMesh::Decimater::DecimaterT<HalfEdges> decimater(edges);
  OpenMesh::Decimater::ModQuadricT<HalfEdges>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<HalfEdges>::Handle folds;
  decimater.add(quadric);
  decimater.add(folds);
  decimater.module(quadric).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  edges.garbage_collection();
  work.check();
  mesh.vertices.clear();
  mesh.triangles.clear();
  for (const auto v : edges.vertices()) {
    const auto& p = edges.point(v);
    mesh.vertices.push_back({p[0], p[1], p[2]});
  }
  for (const auto f : edges.faces()) {
    Triangle t;
    int k = 0;
    for (auto it = edges.cfv_iter(f); it.is_valid(); ++it) t[k++] = it->idx();
    mesh.triangles.push_back(t);
  }
}

}  // namespace terrazzo
