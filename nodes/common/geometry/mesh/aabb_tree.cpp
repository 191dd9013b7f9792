#include "nodes/common/geometry/mesh/aabb_tree.h"

#include <algorithm>
#include <numeric>

namespace terrazzo {

AabbTree::AabbTree(const Mesh& mesh, int leaf_size) {
  std::vector<Aabb> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (int v : mesh.triangles[t]) boxes[t].add(mesh.vertices[v]);
  triangles.resize(boxes.size());
  std::iota(triangles.begin(), triangles.end(), 0);
  if (!boxes.empty()) split(boxes, 0, boxes.size(), leaf_size);
}

void AabbTree::split(const std::vector<Aabb>& boxes, int first, int count, int leaf_size) {
  const std::size_t me = nodes.size();
  nodes.emplace_back();
  Aabb box, centers;
  for (int k = first; k < first + count; ++k) {
    box.add(boxes[triangles[k]]);
    centers.add(boxes[triangles[k]].center());
  }
  nodes[me].box = box;
  if (count <= leaf_size) {
    nodes[me].first = first;
    nodes[me].count = count;
    return;
  }
  int axis;
  (centers.high - centers.low).maxCoeff(&axis);
  const int half = count / 2;
  std::nth_element(triangles.begin() + first, triangles.begin() + first + half,
                   triangles.begin() + first + count, [&](int a, int b) {
                     const double ca = boxes[a].center()[axis], cb = boxes[b].center()[axis];
                     return ca < cb || (ca == cb && a < b);
                   });
  split(boxes, first, half, leaf_size);
  nodes[me].right = nodes.size();
  split(boxes, first + half, count - half, leaf_size);
}

}  // namespace terrazzo
