#include "nodes/common/geometry/mesh_section.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace terrazzo {
namespace {

std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
  const auto lo = static_cast<std::uint64_t>(std::min(a, b)), hi = static_cast<std::uint64_t>(std::max(a, b));
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
    for (const Vec2& p : loop) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  }
  bool contains(const Vec2& p) const {
    return (p.array() >= lo.array()).all() && (p.array() <= hi.array()).all();
  }
};

}  // namespace

std::vector<Loop> section_loops(const Mesh& mesh, const Mat3& a_b_u, double h) {
  const Vec3 a = a_b_u.col(0), b = a_b_u.col(1), u = a_b_u.col(2);
  std::vector<double> height(mesh.vertices.size());
  std::vector<std::uint8_t> above(height.size());  // small enough to stay in the nearest cache
  for (std::size_t v = 0; v < height.size(); ++v) {
    height[v] = u.dot(mesh.vertices[v]) - h;
    above[v] = height[v] >= 0;
  }

  std::vector<Segment> segments;
  for (const auto& t : mesh.triangles) {
    const std::uint8_t up[3] = {above[t[0]], above[t[1]], above[t[2]]};
    if (up[0] + up[1] + up[2] == 0 || up[0] + up[1] + up[2] == 3) continue;
    Segment s{};
    for (int k = 0; k < 3; ++k) {
      const int n = (k + 1) % 3;
      if (up[k] && !up[n]) s.from = edge_key(t[k], t[n]);
      if (!up[k] && up[n]) s.to = edge_key(t[k], t[n]);
    }
    segments.push_back(s);
  }
  std::sort(segments.begin(), segments.end(), [](const Segment& s, const Segment& t) {
    return s.from != t.from ? s.from < t.from : s.to < t.to;
  });

  const auto point = [&](std::uint64_t key) -> Vec2 {
    const auto i = static_cast<std::int32_t>(key >> 32), j = static_cast<std::int32_t>(key & 0xffffffffu);
    const double t = height[i] / (height[i] - height[j]);
    const Vec3 p = mesh.vertices[i] + t * (mesh.vertices[j] - mesh.vertices[i]);
    return {a.dot(p), b.dot(p)};
  };

  std::vector<Loop> loops;
  std::vector<char> used(segments.size(), 0);
  for (std::size_t start = 0; start < segments.size(); ++start) {
    if (used[start]) continue;
    Loop loop;
    for (std::size_t i = start;;) {
      used[i] = 1;
      const Vec2 p = point(segments[i].from);
      if (loop.empty() || p != loop.back()) loop.push_back(p);
      auto next = static_cast<std::size_t>(
          std::lower_bound(segments.begin(), segments.end(), segments[i].to,
                           [](const Segment& s, std::uint64_t key) { return s.from < key; }) -
          segments.begin());
      while (next < segments.size() && segments[next].from == segments[i].to && used[next]) ++next;
      if (next == segments.size() || segments[next].from != segments[i].to) break;
      i = next;
    }
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
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
