#include "nodes/packing/cells/split_edges.h"

#include <cstdint>
#include <unordered_map>

namespace terrazzo::tessellation {
namespace {

// The vertex added on each split edge.
class Splits {
 public:
  // The vertex that splits edge (a, b), or −1.
  int of(int a, int b) const {
    const auto it = added_.find(key(a, b));
    return it == added_.end() ? -1 : it->second;
  }
  void add(int a, int b, int vertex) { added_[key(a, b)] = vertex; }
  bool empty() const { return added_.empty(); }

 private:
  static std::uint64_t key(int a, int b) {
    if (a > b) std::swap(a, b);
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
  }
  std::unordered_map<std::uint64_t, int> added_;  // looked up only, so its order does not matter
};

// Replaces every triangle with split edges by two to four triangles. `may_split` marks those that can have
// some; looking up the edges of all others would take most of the time.
void apply(Mesh& mesh, const Splits& splits, const std::vector<char>& may_split) {
  std::vector<Triangle> out;
  out.reserve(2 * mesh.triangles.size());
  const auto length = [&](int a, int b) { return (mesh.vertices[a] - mesh.vertices[b]).squaredNorm(); };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if (!may_split[i]) {
      out.push_back(t);
      continue;
    }
    int m[3], split = 0;
    for (int k = 0; k < 3; ++k) {
      m[k] = splits.of(t[k], t[(k + 1) % 3]);
      split += m[k] >= 0;
    }
    if (split == 0) {
      out.push_back(t);
    } else if (split == 3) {
      for (int k = 0; k < 3; ++k) out.push_back({t[k], m[k], m[(k + 2) % 3]});
      out.push_back({m[0], m[1], m[2]});
    } else if (split == 1) {
      for (int k = 0; k < 3; ++k)
        if (m[k] >= 0) {
          out.push_back({t[k], m[k], t[(k + 2) % 3]});
          out.push_back({m[k], t[(k + 1) % 3], t[(k + 2) % 3]});
        }
    } else {
      int k = 0;
      while (m[k] >= 0) ++k;  // the edge that is not split: a, b
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], bc = m[(k + 1) % 3], ca = m[(k + 2) % 3];
      out.push_back({c, ca, bc});
      if (length(a, bc) < length(b, ca)) {
        out.push_back({a, b, bc});
        out.push_back({a, bc, ca});
      } else {
        out.push_back({a, b, ca});
        out.push_back({b, bc, ca});
      }
    }
  }
  mesh.triangles = std::move(out);
}

}  // namespace

void split_long_edges(Mesh& mesh, double longest) {
  for (;;) {
    Splits splits;
    std::vector<char> may_split(mesh.triangles.size(), 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
        if ((mesh.vertices[a] - mesh.vertices[b]).norm() <= longest) continue;
        may_split[i] = 1;
        if (splits.of(a, b) >= 0) continue;
        splits.add(a, b, mesh.vertices.size());
        mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
      }
    if (splits.empty()) return;
    apply(mesh, splits, may_split);
  }
}

void split_at_plane(Mesh& mesh, const Vec3& normal, double offset, double near) {
  std::vector<double> height;
  for (const Vec3& v : mesh.vertices) height.push_back(normal.dot(v) - offset);
  Splits splits;
  std::vector<char> may_split(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Triangle& t = mesh.triangles[i];
      const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      const double ha = height[a], hb = height[b];
      if (!((ha > near && hb < -near) || (ha < -near && hb > near))) continue;
      may_split[i] = 1;
      if (splits.of(a, b) >= 0) continue;
      splits.add(a, b, mesh.vertices.size());
      mesh.vertices.push_back(mesh.vertices[a] + ha / (ha - hb) * (mesh.vertices[b] - mesh.vertices[a]));
    }
  if (!splits.empty()) apply(mesh, splits, may_split);
}

}  // namespace terrazzo::tessellation
