#include "nodes/shapes/shape_estimate/methods/extrusions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

// What created a vertex: the faces of three edges (edge of polygon 0, 1, 2), or the line over a corner
// (stored as −1 − corner instead of its polygon's edge) and the face that crosses it (the third is kNone).
using Made = std::array<int, 3>;
constexpr int kNone = 1 << 30;

struct Corner {
  Made made;
  Vec2 at;  // (length along the edge, height) in its face
};

struct Piece {
  Corner a, b;
};

class Solid {
 public:
  explicit Solid(const std::array<Polygon, 3>& polygons) : polygons_(polygons) {}

  // Empty if the outlines of a face do not close, because the polygons are in special position.
  std::optional<Mesh> build(const Work& work) {
    for (int k = 0; k < 3; ++k)
      for (int e = 0; e < size(k); ++e) {
        work.check();
        if (!add_face(k, e)) return {};
      }
    return mesh_;
  }

 private:
  int size(int k) const { return polygons_[k].size(); }
  const Vec2& point(int k, int i) const { return polygons_[k][i % size(k)]; }

  // The face over edge e of polygon k. Its coordinates are the length along the edge and the height along
  // axis k + 2. Polygon k1 = k + 1 holds (x_k+1, height), polygon k2 = k + 2 (height, x_k).
  struct Face {
    int k, e, next;  // next: the edge's second corner
    int k1, k2;
    Vec2 from, edge;
    double length;

    Made made(int own, int one, int two) const {
      Made m;
      m[k] = own;
      m[k1] = one;
      m[k2] = two;
      return m;
    }
  };

  // Edges of another polygon that cross a face.
  struct Crossing {
    std::vector<Piece> pieces;                                 // clipped to the face's ends
    std::vector<int> edges;                                    // of each piece
    std::vector<std::vector<std::pair<double, Corner>>> cuts;  // of each piece, at edges of the third polygon
  };

  bool add_face(int k, int e) {
    const Vec2 from = point(k, e), edge = point(k, e + 1) - from;
    const Face face{k, e, (e + 1) % size(k), (k + 1) % 3, (k + 2) % 3, from, edge, edge.norm()};
    Crossing ones = crossing(face, true), twos = crossing(face, false);
    cut(face, ones, twos);
    pieces_.clear();
    for (std::size_t i = 0; i < ones.pieces.size(); ++i)
      keep_inside(face, false, ones.pieces[i], ones.cuts[i]);
    for (std::size_t j = 0; j < twos.pieces.size(); ++j)
      keep_inside(face, true, twos.pieces[j], twos.cuts[j]);
    for (const bool first : {true, false})
      add_end(k, first ? e : face.next, first ? 0 : face.length, first ? from : from + edge);
    return close(k, e, face.length);
  }

  // Of polygon k1 if `first`, or else of polygon k2.
  Crossing crossing(const Face& face, bool first) const {
    const int other = first ? face.k1 : face.k2;
    const double start = first ? face.from.y() : face.from.x(), run = first ? face.edge.y() : face.edge.x();
    const double low = std::min(start, start + run), high = std::max(start, start + run);
    Crossing out;
    for (int f = 0; f < size(other); ++f) {
      const Vec2 p = point(other, f), q = point(other, f + 1);
      const double wp = first ? p.x() : p.y(), wq = first ? q.x() : q.y();
      const double hp = first ? p.y() : p.x(), hq = first ? q.y() : q.x();
      if (std::max(wp, wq) <= low || std::min(wp, wq) >= high) continue;
      const auto corner = [&](double w, double h, int vertex) {
        const auto own = [&](int of, int what) {
          return first ? face.made(of, what, kNone) : face.made(of, kNone, what);
        };
        if (w <= low || w >= high) {
          const double end = w <= low ? low : high;
          const double t = (end - wp) / (wq - wp);
          const bool at_start = (end == low) == (run > 0);
          return Corner{own(-1 - (at_start ? face.e : face.next), f),
                        Vec2(at_start ? 0 : face.length, hp + t * (hq - hp))};
        }
        return Corner{own(face.e, -1 - vertex), Vec2((w - start) / run * face.length, h)};
      };
      out.pieces.push_back({corner(wp, hp, f), corner(wq, hq, (f + 1) % size(other))});
      out.edges.push_back(f);
    }
    out.cuts.resize(out.pieces.size());
    return out;
  }

  // Intersections between the edges of the two polygons.
  static void cut(const Face& face, Crossing& ones, Crossing& twos) {
    for (std::size_t i = 0; i < ones.pieces.size(); ++i)
      for (std::size_t j = 0; j < twos.pieces.size(); ++j) {
        const Vec2 a = ones.pieces[i].a.at, b = ones.pieces[i].b.at;
        const Vec2 c = twos.pieces[j].a.at, d = twos.pieces[j].b.at;
        const double ca = cross(d - c, a - c), cb = cross(d - c, b - c), ac = cross(b - a, c - a),
                     ad = cross(b - a, d - a);
        if ((ca > 0) == (cb > 0) || (ac > 0) == (ad > 0)) continue;
        const double t = ca / (ca - cb);
        const Corner x{face.made(face.e, ones.edges[i], twos.edges[j]), a + t * (b - a)};
        ones.cuts[i].emplace_back(t, x);
        twos.cuts[j].emplace_back(ac / (ac - ad), x);
      }
  }

  // Whether a point of the face is inside polygon k1 if `first`, or else inside k2.
  bool inside(const Face& face, bool first, const Vec2& p) const {
    const double share = p.x() / face.length;
    return first ? loop_contains(polygons_[face.k1], {face.from.y() + share * face.edge.y(), p.y()})
                 : loop_contains(polygons_[face.k2], {p.y(), face.from.x() + share * face.edge.x()});
  }

  // Keeps the parts of a piece, between its cuts, that are inside polygon k1 or k2.
  void keep_inside(const Face& face, bool first, const Piece& whole,
                   std::vector<std::pair<double, Corner>>& cuts) {
    std::sort(cuts.begin(), cuts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    Corner last = whole.a;
    for (std::size_t c = 0; c <= cuts.size(); ++c) {
      const Corner& end = c < cuts.size() ? cuts[c].second : whole.b;
      if (inside(face, first, (last.at + end.at) / 2)) pieces_.push_back({last, end});
      last = end;
    }
  }

  // The line over a corner: the intervals inside both other polygons.
  void add_end(int k, int corner, double along, const Vec2& at) {
    const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    std::vector<std::pair<double, Made>> cuts;
    for (const int other : {k1, k2})
      for (int f = 0; f < size(other); ++f) {
        const Vec2 p = point(other, f), q = point(other, f + 1);
        const bool first = other == k1;
        const double wp = first ? p.x() : p.y(), wq = first ? q.x() : q.y(), w = first ? at.y() : at.x();
        if ((wp > w) == (wq > w)) continue;
        const double hp = first ? p.y() : p.x(), hq = first ? q.y() : q.x();
        Made m{kNone, kNone, kNone};
        m[k] = -1 - corner;
        m[other] = f;
        cuts.emplace_back(hp + (w - wp) / (wq - wp) * (hq - hp), m);
      }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const double middle = (cuts[c].first + cuts[c + 1].first) / 2;
      if (loop_contains(polygons_[k1], {at.y(), middle}) && loop_contains(polygons_[k2], {middle, at.x()}))
        pieces_.push_back(
            {{cuts[c].second, {along, cuts[c].first}}, {cuts[c + 1].second, {along, cuts[c + 1].first}}});
    }
  }

  // Joins the pieces into loops and triangulates them.
  bool close(int k, int e, double length) {
    std::map<Made, std::vector<std::pair<int, int>>> at;  // piece, end
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      at[pieces_[i].a.made].emplace_back(static_cast<int>(i), 0);
      at[pieces_[i].b.made].emplace_back(static_cast<int>(i), 1);
    }
    for (const auto& [made, ends] : at)
      if (ends.size() != 2) return false;
    std::vector<char> used(pieces_.size(), 0);
    for (std::size_t start = 0; start < pieces_.size(); ++start) {
      if (used[start]) continue;
      std::vector<Corner> loop;
      int piece = start, end = 0;
      while (!used[piece]) {
        used[piece] = 1;
        const Piece& p = pieces_[piece];
        loop.push_back(end == 0 ? p.a : p.b);
        const auto& ends = at[(end == 0 ? p.b : p.a).made];
        const auto other = ends[0] == std::pair(piece, 1 - end) ? ends[1] : ends[0];
        piece = other.first;
        end = other.second;
      }
      if (loop.size() < 3) return false;
      fill(k, e, length, std::move(loop));
    }
    return true;
  }

  std::int32_t vertex(int k, int e, double length, const Corner& c) {
    const auto [it, fresh] = vertices_.try_emplace(c.made, static_cast<std::int32_t>(mesh_.vertices.size()));
    if (fresh) {
      const Vec2 p = point(k, e) + c.at.x() / length * (point(k, e + 1) - point(k, e));
      Vec3 v;
      v[k] = p.x();
      v[(k + 1) % 3] = p.y();
      v[(k + 2) % 3] = c.at.y();
      mesh_.vertices.push_back(v);
    }
    return it->second;
  }

  // Ear clipping, sharpest ear first, to avoid flat triangles.
  void fill(int k, int e, double length, std::vector<Corner> loop) {
    double area = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      area += cross(loop[i].at - loop[0].at, loop[(i + 1) % loop.size()].at - loop[0].at);
    if (area < 0) std::reverse(loop.begin(), loop.end());
    std::vector<std::int32_t> index;
    for (const auto& c : loop) index.push_back(vertex(k, e, length, c));
    std::vector<std::size_t> left(loop.size());
    std::iota(left.begin(), left.end(), 0);
    while (left.size() > 3) {
      const std::size_t n = left.size();
      std::size_t best = n, any = 0;
      double least = -2, flattest = -1e300;
      for (std::size_t i = 0; i < n; ++i) {
        const Vec2 a = loop[left[(i + n - 1) % n]].at, b = loop[left[i]].at, c = loop[left[(i + 1) % n]].at;
        const double twice = cross(b - a, c - b);
        if (twice > flattest) {
          flattest = twice;
          any = i;
        }
        if (twice <= 0) continue;
        bool empty = true;
        for (std::size_t j = 0; empty && j < n; ++j) {
          if (j == i || j == (i + 1) % n || j == (i + n - 1) % n) continue;
          const Vec2 q = loop[left[j]].at;
          empty = cross(b - a, q - a) < 0 || cross(c - b, q - b) < 0 || cross(a - c, q - c) < 0;
        }
        if (!empty) continue;
        // The cosine at the ear's tip.
        const double cosine = (a - b).dot(c - b) / ((a - b).norm() * (c - b).norm());
        if (cosine > least) {
          least = cosine;
          best = i;
        }
      }
      if (best == n) best = any;  // only rounding can cause this: any triangle keeps the mesh closed
      mesh_.triangles.push_back(
          {index[left[(best + n - 1) % n]], index[left[best]], index[left[(best + 1) % n]]});
      left.erase(left.begin() + best);
    }
    mesh_.triangles.push_back({index[left[0]], index[left[1]], index[left[2]]});
  }

  const std::array<Polygon, 3>& polygons_;
  std::vector<Piece> pieces_;
  std::map<Made, std::int32_t> vertices_;
  Mesh mesh_;
};

Mesh largest_piece(const Mesh& mesh) {
  DisjointSets pieces(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    pieces.join(t[0], t[1]);
    pieces.join(t[0], t[2]);
  }
  std::map<std::int32_t, double> volume;
  for (const auto& t : mesh.triangles)
    volume[pieces.find(t[0])] += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  std::int32_t best = volume.begin()->first;
  for (const auto& [r, v] : volume)
    if (v > volume[best]) best = r;
  Mesh out;
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  for (const auto& t : mesh.triangles) {
    if (pieces.find(t[0]) != best) continue;
    Triangle moved{};
    for (int k = 0; k < 3; ++k) {
      if (number[t[k]] < 0) {
        number[t[k]] = out.vertices.size();
        out.vertices.push_back(mesh.vertices[t[k]]);
      }
      moved[k] = number[t[k]];
    }
    out.triangles.push_back(moved);
  }
  return out;
}

void simplify(const Polygon& p, std::size_t from, std::size_t to, double distance, std::vector<char>& keep) {
  // Simplifies the points from … to; indices may run past the end.
  const auto at = [&](std::size_t i) { return p[i % p.size()]; };
  double most = 0;
  std::size_t farthest = from;
  const Vec2 d = at(to) - at(from);
  for (std::size_t i = from + 1; i < to; ++i) {
    const double t = std::clamp((at(i) - at(from)).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    const double away = (at(i) - at(from) - t * d).norm();
    if (away > most) {
      most = away;
      farthest = i;
    }
  }
  if (most <= distance) return;
  keep[farthest % p.size()] = 1;
  simplify(p, from, farthest, distance, keep);
  simplify(p, farthest, to, distance, keep);
}

}  // namespace

Polygon simplified(const Polygon& p, double distance) {
  // Start from the two ends of the extent in x, which are kept.
  std::size_t low = 0, high = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i].x() < p[low].x()) low = i;
    if (p[i].x() > p[high].x()) high = i;
  }
  std::vector<char> keep(p.size(), 0);
  keep[low] = keep[high] = 1;
  const std::size_t first = std::min(low, high), second = std::max(low, high);
  simplify(p, first, second, distance, keep);
  simplify(p, second, first + p.size(), distance, keep);
  Polygon out;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (keep[i]) out.push_back(p[i]);
  return out.size() >= 3 ? out : p;
}

Mesh intersect_extrusions(const std::array<Polygon, 3>& polygons, const Work& work) {
  constexpr int kTries = 12;
  double extent = 0;
  for (const auto& p : polygons)
    for (const auto& v : p) extent = std::max(extent, v.cwiseAbs().maxCoeff());
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::array<Polygon, 3> moved = polygons;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < moved[k].size(); ++i) {
        Random r(static_cast<std::uint64_t>(attempt), 204 + k, i);
        moved[k][i] += 1e-7 * extent * Vec2(r.uniform(-1, 1), r.uniform(-1, 1));
      }
    const auto mesh = Solid(moved).build(work);
    if (!mesh || (!mesh->triangles.empty() && !mesh_faults(*mesh).empty())) continue;
    return mesh->triangles.empty() ? *mesh : largest_piece(*mesh);
  }
  throw Error("no-intersection", "the extrusions of the three profiles could not be intersected",
              "choose other profiles");
}

}  // namespace terrazzo::shape_estimate
