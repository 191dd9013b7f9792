#include "nodes/export/cut_mesh.h"

#include <GL/glu.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <unordered_map>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

using Edge = std::pair<std::int32_t, std::int32_t>;
using Loops = std::vector<std::vector<std::int32_t>>;

[[noreturn]] void fail_open() {
  throw Error("open-mesh", "a mesh that crosses the side of the box is not closed, so it cannot be cut",
              "use closed shapes, or crossing: repeated");
}

// A point of a tessellated polygon: GLU passes its address on.
struct CapPoint {
  std::array<GLdouble, 3> at{};
  std::int32_t vertex = 0;
};

// The triangles of a cap. GLU calls the functions below with it.
struct Cap {
  Mesh& mesh;
  int axis;
  int u, v;       // axes of the cap's plane, seen from outside: u to the right, v up
  double height;  // along `axis`
  std::deque<CapPoint> points = {};
  std::vector<std::int32_t> corners = {};
  bool failed = false;

  CapPoint& add(std::int32_t vertex) {
    const Vec3& p = mesh.vertices[vertex];
    return points.emplace_back(CapPoint{{p[u], p[v], 0}, vertex});
  }
};

void take_corner(void* point, void* cap) {
  static_cast<Cap*>(cap)->corners.push_back(static_cast<CapPoint*>(point)->vertex);
}
// Where outlines cross, which happens only if the mesh intersects itself, or touch.
void join_points(GLdouble at[3], void**, GLfloat*, void** out, void* data) {
  Cap& cap = *static_cast<Cap*>(data);
  Vec3 p;
  p[cap.axis] = cap.height;
  p[cap.u] = at[0];
  p[cap.v] = at[1];
  cap.mesh.vertices.push_back(p);
  *out = &cap.add(count_of(cap.mesh.vertices) - 1);
}
void keep_triangles(GLboolean, void*) {}  // with this callback, GLU makes triangles only, no fans or strips
void fail_cap(GLenum, void* cap) { static_cast<Cap*>(cap)->failed = true; }

using Callback = void (*)();

// Joins directed edges to loops. Where several start at one vertex, any will do: the loops touch there.
Loops loops_of(const std::vector<Edge>& edges) {
  std::multimap<std::int32_t, std::int32_t> next(edges.begin(), edges.end());
  Loops loops;
  while (!next.empty()) {
    const std::int32_t start = next.begin()->first;
    std::vector<std::int32_t>& loop = loops.emplace_back();
    for (std::int32_t at = start; loop.empty() || at != start;) {
      const auto step = next.find(at);
      if (step == next.end()) fail_open();
      loop.push_back(at);
      at = step->second;
      next.erase(step);
    }
  }
  return loops;
}

// Adds the triangles inside of the loops, which are counterclockwise seen from outside, holes clockwise.
void add_cap(Cap& cap, const Loops& loops) {
  const std::unique_ptr<GLUtesselator, decltype(&gluDeleteTess)> tess(gluNewTess(), gluDeleteTess);
  gluTessProperty(tess.get(), GLU_TESS_WINDING_RULE, GLU_TESS_WINDING_POSITIVE);
  gluTessNormal(tess.get(), 0, 0, 1);
  gluTessCallback(tess.get(), GLU_TESS_VERTEX_DATA, reinterpret_cast<Callback>(take_corner));
  gluTessCallback(tess.get(), GLU_TESS_COMBINE_DATA, reinterpret_cast<Callback>(join_points));
  gluTessCallback(tess.get(), GLU_TESS_EDGE_FLAG_DATA, reinterpret_cast<Callback>(keep_triangles));
  gluTessCallback(tess.get(), GLU_TESS_ERROR_DATA, reinterpret_cast<Callback>(fail_cap));
  gluTessBeginPolygon(tess.get(), &cap);
  for (const auto& loop : loops) {
    gluTessBeginContour(tess.get());
    for (const std::int32_t vertex : loop) {
      CapPoint& point = cap.add(vertex);
      gluTessVertex(tess.get(), point.at.data(), &point);
    }
    gluTessEndContour(tess.get());
  }
  gluTessEndPolygon(tess.get());
  if (cap.failed) fail_open();
  for (std::size_t i = 0; i + 2 < cap.corners.size(); i += 3)
    cap.mesh.triangles.push_back({cap.corners[i], cap.corners[i + 1], cap.corners[i + 2]});
}

// GLU leaves out loops without area, whose points are on one line. Fans of triangles without area close them,
// so that every edge has its two triangles when the mesh is cut again. `first`: of the cap's triangles.
void close_seams(Mesh& mesh, std::size_t first, const std::vector<Edge>& edges) {
  std::map<Edge, int> left;  // of each edge, less those in the other direction
  const auto count = [&](std::int32_t a, std::int32_t b, int sign) {
    if (a < b)
      left[{a, b}] += sign;
    else
      left[{b, a}] -= sign;
  };
  for (const auto& [a, b] : edges) count(a, b, 1);
  for (std::size_t t = first; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) count(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3], -1);
  std::vector<Edge> seams;
  for (const auto& [edge, times] : left)
    for (int i = 0; i < std::abs(times); ++i)
      seams.push_back(times > 0 ? edge : Edge(edge.second, edge.first));
  for (const auto& loop : loops_of(seams))
    for (std::size_t i = 2; i < loop.size(); ++i) mesh.triangles.push_back({loop[0], loop[i - 1], loop[i]});
}

// Drops pairs of triangles that have the same corners and face away from each other.
void drop_opposites(std::vector<Triangle>& triangles) {
  std::map<Triangle, int> times;  // by sorted corners: how many more face one way than the other
  const auto sorted = [](Triangle t) {
    int turn = 1;
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
      if (t[a] > t[b]) {
        std::swap(t[a], t[b]);
        turn = -turn;
      }
    return std::pair(t, turn);
  };
  for (const Triangle& t : triangles) {
    const auto [corners, turn] = sorted(t);
    times[corners] += turn;
  }
  std::erase_if(triangles, [&](const Triangle& t) {
    const auto [corners, turn] = sorted(t);
    int& left = times[corners];
    if (left * turn <= 0) return true;
    left -= turn;
    return false;
  });
}

// Joins vertices at the same place, and drops triangles of fewer than three places and unused vertices.
Mesh welded(const Mesh& mesh) {
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::map<Vec3, std::int32_t, decltype(less)> places(less);
  Mesh out;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    if (a == b || b == c || c == a) continue;
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const auto [place, added] = places.emplace(mesh.vertices[t[k]], count_of(out.vertices));
      if (added) out.vertices.push_back(mesh.vertices[t[k]]);
      corners[k] = place->second;
    }
    out.triangles.push_back(corners);
  }
  drop_opposites(out.triangles);
  return out;
}

// Cuts the triangles of a mesh by a plane.
class PlaneCut {
 public:
  PlaneCut(const Mesh& mesh, int axis, double at, bool below)
      : mesh_(mesh), axis_(axis), at_(at), below_(below) {}

  Mesh cut() {
    out_.vertices = mesh_.vertices;
    for (const Triangle& t : mesh_.triangles) add(t);
    // Seen from outside, which is against the axis for the part above.
    const int first = (axis_ + 1) % 3, second = (axis_ + 2) % 3;
    Cap cap{out_, axis_, below_ ? first : second, below_ ? second : first, at_};
    const std::size_t first_of_cap = out_.triangles.size();
    if (!edges_.empty()) add_cap(cap, loops_of(edges_));
    close_seams(out_, first_of_cap, edges_);
    return welded(out_);
  }

 private:
  bool inside(std::int32_t v) const {
    return below_ ? mesh_.vertices[v][axis_] < at_ : mesh_.vertices[v][axis_] > at_;
  }

  // The vertex where an edge meets the plane. Computed from its lower end in lexicographic order, so that all
  // parts that share the edge get the same point.
  std::int32_t crossing(std::int32_t a, std::int32_t b) {
    const Edge edge = std::minmax(a, b);
    const auto [known, added] =
        crossings_.emplace(std::uint64_t(edge.first) << 32 | std::uint64_t(edge.second), 0);
    if (!added) return known->second;
    Vec3 p = mesh_.vertices[a], q = mesh_.vertices[b];
    if (std::lexicographical_compare(q.data(), q.data() + 3, p.data(), p.data() + 3)) std::swap(p, q);
    Vec3 at = p + (q - p) * ((at_ - p[axis_]) / (q[axis_] - p[axis_]));
    at[axis_] = at_;
    out_.vertices.push_back(at);
    return known->second = count_of(out_.vertices) - 1;
  }

  void add(const Triangle& t) {
    const std::array<bool, 3> in = {inside(t[0]), inside(t[1]), inside(t[2])};
    const int count = in[0] + in[1] + in[2];
    if (count == 3) out_.triangles.push_back(t);
    if (count == 0 || count == 3) return;
    // Corner k is alone on its side.
    int k = 0;
    while (in[k] != (count == 1)) ++k;
    const std::int32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const std::int32_t ab = crossing(a, b), ca = crossing(c, a);
    if (count == 1) {
      out_.triangles.push_back({a, ab, ca});
      edges_.emplace_back(ca, ab);
    } else {
      out_.triangles.push_back({ab, b, c});
      out_.triangles.push_back({ab, c, ca});
      edges_.emplace_back(ab, ca);
    }
  }

  const Mesh& mesh_;
  int axis_;
  double at_;
  bool below_;
  Mesh out_;
  std::unordered_map<std::uint64_t, std::int32_t> crossings_;
  std::vector<Edge> edges_;  // of the cap
};

std::pair<double, double> range(const Mesh& mesh, int axis) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3& v : mesh.vertices) {
    low = std::min(low, v[axis]);
    high = std::max(high, v[axis]);
  }
  return {low, high};
}

// The part between two sides of a cell, moved by whole edges into the box.
Mesh part_of_cell(const Mesh& mesh, int axis, double cell, double edge) {
  const double low = cell * edge, high = (cell + 1) * edge;
  const auto [from, to] = range(mesh, axis);
  Mesh part = from < low ? cut_mesh(mesh, axis, low, false) : mesh;
  if (to > high) part = cut_mesh(part, axis, high, true);
  for (Vec3& v : part.vertices) v[axis] = v[axis] == high ? edge : std::clamp(v[axis] - low, 0.0, edge);
  return part;
}

}  // namespace

Mesh cut_mesh(const Mesh& mesh, int axis, double at, bool below) {
  return PlaneCut(mesh, axis, at, below).cut();
}

std::vector<Mesh> parts_in_box(const Mesh& mesh, const Vec3& box) {
  std::vector<Mesh> parts = {mesh};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Mesh> next;
    for (const Mesh& part : parts) {
      const auto [low, high] = range(part, axis);
      for (double cell = std::floor(low / box[axis]); cell * box[axis] < high; ++cell) {
        Mesh piece = part_of_cell(part, axis, cell, box[axis]);
        if (!piece.triangles.empty()) next.push_back(std::move(piece));
      }
    }
    parts = std::move(next);
  }
  return parts;
}

Mesh with_flat_caps(const Mesh& mesh, const Vec3& box) {
  Mesh out = mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, box[axis]}) {
      std::map<std::int32_t, std::int32_t> own;
      for (Triangle& t : out.triangles) {
        if (!std::all_of(t.begin(), t.end(), [&](std::int32_t v) { return out.vertices[v][axis] == side; }))
          continue;
        for (std::int32_t& v : t) {
          const auto [copy, added] = own.emplace(v, count_of(out.vertices));
          if (added) out.vertices.push_back(Vec3(out.vertices[v]));
          v = copy->second;
        }
      }
    }
  return out;
}

}  // namespace terrazzo::exporting
