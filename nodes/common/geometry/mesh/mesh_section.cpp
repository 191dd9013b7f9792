#include "nodes/common/geometry/mesh/mesh_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace terrazzo {
namespace {

std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
  const std::uint64_t lo = std::min(a, b), hi = std::max(a, b);
  return lo << 32 | hi;
}

// The part of the section in one triangle: from the edge where the triangle's boundary goes down through the
// plane to the edge where it comes up, so that the solid is on the left.
struct Segment {
  std::uint64_t from, to;
};

struct Box {
  Vec2 lo = Vec2::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  explicit Box(const Loop& loop) {
    for (const Vec2& p : loop) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
  }
  bool contains(const Vec2& p) const {
    return (p.array() >= lo.array()).all() && (p.array() <= hi.array()).all();
  }
};

// u·(x, y, z), always in the same order of operations.
double product(const Vec3& u, double x, double y, double z) { return (u.x() * x + u.y() * y) + u.z() * z; }

using Chain = std::vector<std::uint32_t>;  // indices of segments

// Chains in the order of their first segments, each from the unused segment with the smallest `from` on.
// Sorts the segments.
std::vector<Chain> sorted_chains(std::vector<Segment>& segments) {
  std::sort(segments.begin(), segments.end(), [](const Segment& s, const Segment& t) {
    return s.from != t.from ? s.from < t.from : s.to < t.to;
  });
  std::vector<Chain> chains;
  std::vector<char> used(segments.size(), 0);
  for (std::size_t start = 0; start < segments.size(); ++start) {
    if (used[start]) continue;
    chains.emplace_back();
    for (std::size_t i = start;;) {
      used[i] = 1;
      chains.back().push_back(static_cast<std::uint32_t>(i));
      std::size_t next = std::lower_bound(segments.begin(), segments.end(), segments[i].to,
                                          [](const Segment& s, std::uint64_t key) { return s.from < key; }) -
                         segments.begin();
      while (next < segments.size() && segments[next].from == segments[i].to && used[next]) ++next;
      if (next == segments.size() || segments[next].from != segments[i].to) break;
      i = next;
    }
  }
  return chains;
}

// For each segment the one that starts where it ends. Empty if there is none, or if several start or end
// there.
std::vector<std::uint32_t> successors(const std::vector<Segment>& segments) {
  constexpr std::uint32_t kNone = 0xffffffffu;
  std::size_t size = 16;
  while (size < 2 * segments.size()) size *= 2;
  std::vector<std::uint32_t> table(size, kNone);  // by a hash of `from`, open addressing
  const auto place = [&](std::uint64_t key) {
    std::size_t at = (key * 0x9e3779b97f4a7c15u) >> 32 & (size - 1);
    while (table[at] != kNone && segments[table[at]].from != key) at = (at + 1) & (size - 1);
    return at;
  };
  for (std::size_t i = 0; i < segments.size(); ++i) {
    std::uint32_t& at = table[place(segments[i].from)];
    if (at != kNone) return {};
    at = i;
  }
  std::vector<std::uint32_t> next(segments.size());
  std::vector<char> reached(segments.size(), 0);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    next[i] = table[place(segments[i].to)];
    if (next[i] == kNone || reached[next[i]]++) return {};
  }
  return next;
}

// The chains of sorted_chains, which on a closed surface without touching edges need no sorting.
std::vector<Chain> chains_of(std::vector<Segment>& segments) {
  const auto next = successors(segments);
  if (next.empty()) return sorted_chains(segments);
  std::vector<Chain> chains;
  std::vector<char> used(segments.size(), 0);
  const auto less = [&](std::uint32_t i, std::uint32_t j) { return segments[i].from < segments[j].from; };
  for (std::uint32_t start = 0; start < segments.size(); ++start) {
    if (used[start]) continue;
    Chain& chain = chains.emplace_back();
    for (std::uint32_t i = start; !used[i]; i = next[i]) {
      used[i] = 1;
      chain.push_back(i);
    }
    std::rotate(chain.begin(), std::min_element(chain.begin(), chain.end(), less), chain.end());
  }
  std::sort(chains.begin(), chains.end(), [&](const Chain& s, const Chain& t) { return less(s[0], t[0]); });
  return chains;
}

// The loops of the plane u·x = h, where `along` is u·x for each vertex, through the triangles [first, last)
// of each range; no other triangle of `mesh` may reach both sides of the plane.
std::vector<Loop> loops_through(const Mesh& mesh, const Mat3& a_b_u, const std::vector<double>& along,
                                double h, const std::vector<std::pair<std::size_t, std::size_t>>& ranges) {
  const Vec3 a = a_b_u.col(0), b = a_b_u.col(1);
  std::vector<Segment> segments;
  for (const auto& [first, last] : ranges)
    for (std::size_t i = first; i < last; ++i) {
      const auto& t = mesh.triangles[i];
      const bool up[3] = {along[t[0]] >= h, along[t[1]] >= h, along[t[2]] >= h};
      if (up[0] + up[1] + up[2] == 0 || up[0] + up[1] + up[2] == 3) continue;
      Segment s{};
      for (int k = 0; k < 3; ++k) {
        const int n = (k + 1) % 3;
        if (up[k] && !up[n]) s.from = edge_key(t[k], t[n]);
        if (!up[k] && up[n]) s.to = edge_key(t[k], t[n]);
      }
      segments.push_back(s);
    }

  const auto point = [&](std::uint64_t key) -> Vec2 {
    const std::int32_t i = key >> 32, j = key & 0xffffffffu;
    const double at_i = along[i] - h, at_j = along[j] - h, t = at_i / (at_i - at_j);
    const Vec3 p = mesh.vertices[i] + t * (mesh.vertices[j] - mesh.vertices[i]);
    return {a.dot(p), b.dot(p)};
  };
  std::vector<Loop> loops;
  for (const auto& chain : chains_of(segments)) {
    Loop loop;
    for (const std::uint32_t i : chain) {
      const Vec2 p = point(segments[i].from);
      if (loop.empty() || p != loop.back()) loop.push_back(p);
    }
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace

std::vector<Loop> section_loops(const Mesh& mesh, const Mat3& a_b_u, double h) {
  const Vec3 u = a_b_u.col(2);
  std::vector<double> along(mesh.vertices.size());
  for (std::size_t v = 0; v < along.size(); ++v) {
    const Vec3& p = mesh.vertices[v];
    along[v] = product(u, p.x(), p.y(), p.z());
  }
  return loops_through(mesh, a_b_u, along, h, {{0, mesh.triangles.size()}});
}

MeshCutter::MeshCutter(const Mesh& mesh)
    : mesh_(mesh), x_(mesh.vertices.size()), y_(x_.size()), z_(x_.size()), along_(x_.size()) {
  for (std::size_t v = 0; v < x_.size(); ++v) {
    x_[v] = mesh.vertices[v].x();
    y_[v] = mesh.vertices[v].y();
    z_[v] = mesh.vertices[v].z();
  }
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kCluster) {
    Cluster c{{}, 0, first, std::min(first + kCluster, mesh.triangles.size())};
    Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
    const auto each = [&](const auto& visit) {
      for (std::size_t i = c.first; i < c.last; ++i)
        for (const auto v : mesh.triangles[i]) visit(mesh.vertices[v]);
    };
    each([&](const Vec3& p) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    });
    c.center = (lo + hi) / 2;
    each([&](const Vec3& p) { c.radius = std::max(c.radius, (p - c.center).norm()); });
    // Distances of planes are rounded; a cluster that only touches the plane has to be visited.
    c.radius += 1e-9 * (c.radius + c.center.norm());
    clusters_.push_back(c);
  }
}

std::pair<double, double> MeshCutter::turn(const Vec3& u) {
  u_ = u;
  for (std::size_t v = 0; v < x_.size(); ++v) along_[v] = product(u, x_[v], y_[v], z_[v]);
  constexpr std::size_t kLanes = 8;  // of independent comparisons
  std::array<double, kLanes> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-low[0]);
  std::size_t v = 0;
  for (; v + kLanes <= along_.size(); v += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      low[k] = std::min(low[k], along_[v + k]);
      high[k] = std::max(high[k], along_[v + k]);
    }
  for (; v < along_.size(); ++v) {
    low[0] = std::min(low[0], along_[v]);
    high[0] = std::max(high[0], along_[v]);
  }
  return {*std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end())};
}

std::vector<Loop> MeshCutter::loops(const Mat3& a_b_u, double h) {
  if (a_b_u.col(2) != u_) turn(a_b_u.col(2));
  ranges_.clear();
  for (const Cluster& c : clusters_)
    if (!(std::abs(u_.dot(c.center) - h) > c.radius)) ranges_.emplace_back(c.first, c.last);
  return loops_through(mesh_, a_b_u, along_, h, ranges_);
}

std::vector<std::vector<Loop>> section_profiles(std::vector<Loop> loops) {
  std::vector<std::vector<Loop>> profiles;
  std::vector<double> area;
  std::vector<Box> box;
  std::vector<Loop> holes;
  for (Loop& loop : loops) {
    const double signed_area = loop_area(loop);
    if (signed_area > 0) {
      area.push_back(signed_area);
      box.emplace_back(loop);
      profiles.push_back({std::move(loop)});
    } else if (signed_area < 0) {
      holes.push_back(std::move(loop));
    }
  }
  for (Loop& hole : holes) {
    const Vec2 p = (hole[0] + hole[1]) / 2;
    std::size_t owner = profiles.size();
    for (std::size_t i = 0; i < profiles.size(); ++i)
      if ((owner == profiles.size() || area[i] < area[owner]) && box[i].contains(p) &&
          loop_contains(profiles[i][0], p))
        owner = i;
    if (owner < profiles.size()) profiles[owner].push_back(std::move(hole));
  }
  return profiles;
}

}  // namespace terrazzo
