#include "nodes/volumes/voxelize/scan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/data/indices.h"

namespace terrazzo::voxelize {
namespace {

struct Crossing {
  std::uint32_t row;
  float sign;
  double x;
};

struct PlanePoint {
  double x, y;
};

// Intersection of an edge with the plane z = h. The endpoints are ordered by index, so that both triangles of
// the edge get the same bits.
PlanePoint on_edge(const std::vector<Vec3>& v, std::int32_t a, std::int32_t b, double h) {
  if (a > b) std::swap(a, b);
  const double t = (h - v[a].z()) / (v[b].z() - v[a].z());
  return {v[a].x() + t * (v[b].x() - v[a].x()), v[a].y() + t * (v[b].y() - v[a].y())};
}

// First integer ≥ v, kept within [lo, hi].
int first_at(double v, int lo, int hi) { return round_up(std::clamp(v, double(lo), double(hi))); }

// Lines along x. Every cell has `lines` planes across z with one line each, at a y that differs between
// planes.
class Lines {
 public:
  Lines(const CellBox& box, int lines) : box_(box), lines_(lines) {
    int before = 1;  // the Fibonacci number before `lines` (1 for 1), which generates the lattice
    for (int a = 1, b = 1; b <= lines; std::swap(a, b), b += a) before = a;
    for (int i = 0; i < lines; ++i) {
      const double y = 0.5 + static_cast<double>((i - lines / 2) * before) / lines;
      offset_.push_back(y - std::floor(y));
    }
  }

  void add(const std::vector<Vec3>& v, const Triangle& t) {
    const double za = v[t[0]].z(), zb = v[t[1]].z(), zc = v[t[2]].z();
    // Include one more plane on each side. Only the comparison of heights decides which planes the triangle
    // meets.
    const auto plane_of = [&](double z) { return (z - box_.lo.z() + 0.5) * lines_ - 0.5; };
    const int end = box_.size.z() * lines_;
    const int first = std::max(0, first_at(plane_of(std::min({za, zb, zc})), 0, end) - 1);
    const int last = std::min(end - 1, first_at(plane_of(std::max({za, zb, zc})), 0, end) + 1);
    for (int plane = first; plane <= last; ++plane) {
      const double h = box_.lo.z() - 0.5 + (plane + 0.5) / lines_;
      const bool up[3] = {za >= h, zb >= h, zc >= h};
      if (up[0] == up[1] && up[1] == up[2]) continue;
      PlanePoint enter{}, leave{};
      for (int e = 0; e < 3; ++e) {
        const int n = (e + 1) % 3;
        if (!up[e] && up[n]) enter = on_edge(v, t[e], t[n], h);
        if (up[e] && !up[n]) leave = on_edge(v, t[e], t[n], h);
      }
      add_segment(plane, enter, leave);
    }
  }

  void fill(Scan& out) {
    // Counting sort by row, then sort by x. Ties need no order, because empty runs add nothing.
    const std::size_t rows = box_.size.y();
    std::vector<std::uint32_t> start(rows * box_.size.z() * lines_ + 1, 0);
    for (const Crossing& c : crossings_) ++start[c.row + 1];
    for (std::size_t r = 1; r < start.size(); ++r) start[r] += start[r - 1];
    std::vector<std::pair<double, float>> sorted(crossings_.size());
    for (const Crossing& c : crossings_) sorted[start[c.row]++] = {c.x, c.sign};
    std::uint32_t begin = 0;
    for (std::size_t row = 0; row + 1 < start.size(); ++row) {
      const std::uint32_t end = start[row];  // advanced by the scatter above
      if (begin == end) continue;
      std::sort(sorted.begin() + begin, sorted.begin() + end);
      const std::size_t plane = row / rows;
      const bool central = static_cast<int>(plane % lines_) == lines_ / 2;
      const std::size_t at = (plane / lines_ * rows + row % rows) * box_.size.x();
      float winding = 0;
      for (std::uint32_t i = begin; i < end; ++i) {
        if (winding != 0)
          add_run(out, at, sorted[i - 1].first - box_.lo.x(), sorted[i].first - box_.lo.x(), central);
        winding += sorted[i].second;
      }
      begin = end;
    }
    const float all = lines_;
    for (float& c : out.coverage) c = c >= all - 1e-3f ? 1.0f : c / all;
  }

 private:
  void add_segment(int plane, PlanePoint a, PlanePoint b) {
    const float sign = b.y > a.y ? 1 : -1;
    if (a.y > b.y) std::swap(a, b);  // same arithmetic in both directions
    const double bottom = box_.lo.y() - 0.5 + offset_[plane % lines_];
    const int rows = box_.size.y();
    const int first = first_at(a.y - bottom, 0, rows), last = first_at(b.y - bottom, 0, rows);
    for (int row = first; row < last; ++row) {
      const double t = std::clamp((bottom + row - a.y) / (b.y - a.y), 0.0, 1.0);
      crossings_.push_back({static_cast<std::uint32_t>(plane) * rows + row, sign, a.x + t * (b.x - a.x)});
    }
  }

  // Adds the run [x0, x1) of a line, in cells from the box's first cell; cell i spans [i − ½, i + ½).
  void add_run(Scan& out, std::size_t at, double x0, double x1, bool central) const {
    const double lo = std::max(x0, -0.5), hi = std::min(x1, box_.size.x() - 0.5);
    if (hi <= lo) return;
    const int first = round_down(lo + 0.5);
    const int last = std::min(round_down(hi + 0.5), box_.size.x() - 1);
    if (first == last) {
      out.coverage[at + first] += static_cast<float>(hi - lo);
    } else {
      out.coverage[at + first] += static_cast<float>(first + 0.5 - lo);
      for (int i = first + 1; i < last; ++i) out.coverage[at + i] += 1;
      out.coverage[at + last] += static_cast<float>(hi - (last - 0.5));
    }
    if (central)
      for (int i = std::max(0, round_up(lo)); i < hi; ++i) out.inside[at + i] = 1;
  }

  const CellBox& box_;
  int lines_;
  std::vector<double> offset_;  // y of each plane's line within its cell
  std::vector<Crossing> crossings_;
};

}  // namespace

void scan_mesh(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const CellBox& box,
               int lines, Scan& out) {
  out.coverage.assign(box.count(), 0);
  out.inside.assign(box.count(), 0);
  Lines all(box, lines);
  for (const auto& t : triangles) all.add(vertices, t);
  all.fill(out);
}

}  // namespace terrazzo::voxelize
