#include "nodes/voxelize/scan.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terrazzo {
namespace {

struct Crossing {
  std::uint32_t row;
  float sign;
  double x;
};

struct PlanePoint {
  double x, y;
};

// Where an edge meets the plane z = h. The ends are taken in the order of their indices, so that both
// triangles of the edge get the same bits.
PlanePoint on_edge(const std::vector<Vec3>& v, std::int32_t a, std::int32_t b, double h) {
  if (a > b) std::swap(a, b);
  const double t = (h - v[a].z()) / (v[b].z() - v[a].z());
  return {v[a].x() + t * (v[b].x() - v[a].x()), v[a].y() + t * (v[b].y() - v[a].y())};
}

// First integer ≥ v, kept within [lo, hi].
int first_at(double v, int lo, int hi) {
  return static_cast<int>(std::ceil(std::clamp(v, double(lo), double(hi))));
}

class Rows {
 public:
  Rows(const CellBox& box, int rows) : box_(box), rows_(rows) {}

  // Sub-lattice line (J, K): y = lo.y − ½ + (J + ½)/rows.
  double line_of(double coordinate, int lo) const { return (coordinate - lo + 0.5) * rows_ - 0.5; }

  void add(const std::vector<Vec3>& v, const Triangle& t) {
    const double za = v[t[0]].z(), zb = v[t[1]].z(), zc = v[t[2]].z();
    const int end = box_.size.z() * rows_;
    const int first = first_at(line_of(std::min({za, zb, zc}), box_.lo.z()), 0, end);
    const int last =
        std::min(end - 1, static_cast<int>(std::floor(
                              std::clamp(line_of(std::max({za, zb, zc}), box_.lo.z()), -1.0, double(end)))));
    for (int K = first; K <= last; ++K) {
      const double h = box_.lo.z() - 0.5 + (K + 0.5) / rows_;
      const bool up[3] = {za >= h, zb >= h, zc >= h};
      if (up[0] == up[1] && up[1] == up[2]) continue;
      PlanePoint enter{}, leave{};
      for (int e = 0; e < 3; ++e) {
        const int n = (e + 1) % 3;
        if (!up[e] && up[n]) enter = on_edge(v, t[e], t[n], h);
        if (up[e] && !up[n]) leave = on_edge(v, t[e], t[n], h);
      }
      add_segment(K, enter, leave);
    }
  }

  void fill(Scan& out) {
    // By row (a counting sort), then along it. Ties need no order: runs of no length add nothing.
    const int lines = box_.size.y() * rows_;
    std::vector<std::uint32_t> start(static_cast<std::size_t>(lines) * box_.size.z() * rows_ + 1, 0);
    for (const Crossing& c : crossings_) ++start[c.row + 1];
    for (std::size_t r = 1; r < start.size(); ++r) start[r] += start[r - 1];
    std::vector<std::pair<double, float>> sorted(crossings_.size());
    for (const Crossing& c : crossings_) sorted[start[c.row]++] = {c.x, c.sign};
    std::uint32_t begin = 0;
    for (std::size_t row = 0; row + 1 < start.size(); ++row) {
      const std::uint32_t end = start[row];  // moved on by the scattering
      if (begin == end) continue;
      std::sort(sorted.begin() + begin, sorted.begin() + end);
      const int K = static_cast<int>(row / lines), J = static_cast<int>(row % lines);
      const bool central = J % rows_ == rows_ / 2 && K % rows_ == rows_ / 2;
      const std::size_t at =
          (static_cast<std::size_t>(K / rows_) * box_.size.y() + J / rows_) * box_.size.x();
      float winding = 0;
      for (std::uint32_t i = begin; i < end; ++i) {
        if (winding != 0)
          add_run(out, at, sorted[i - 1].first - box_.lo.x(), sorted[i].first - box_.lo.x(), central);
        winding += sorted[i].second;
      }
      begin = end;
    }
    const float share = 1.0f / static_cast<float>(rows_ * rows_);
    const float full = static_cast<float>(rows_ * rows_) - 1e-3f;
    for (float& c : out.coverage) c = c >= full ? 1.0f : c * share;
  }

 private:
  void add_segment(int K, PlanePoint a, PlanePoint b) {
    const float sign = b.y > a.y ? 1 : -1;
    if (a.y > b.y) std::swap(a, b);  // the same arithmetic for both directions
    const int lines = box_.size.y() * rows_;
    const int first = first_at(line_of(a.y, box_.lo.y()), 0, lines);
    const int last = first_at(line_of(b.y, box_.lo.y()), 0, lines);
    for (int J = first; J < last; ++J) {
      const double y = box_.lo.y() - 0.5 + (J + 0.5) / rows_;
      const double t = std::clamp((y - a.y) / (b.y - a.y), 0.0, 1.0);
      crossings_.push_back({static_cast<std::uint32_t>(K) * lines + J, sign, a.x + t * (b.x - a.x)});
    }
  }

  // The run [x0, x1) of a line, in cells from the box's first; cell i spans [i − ½, i + ½).
  void add_run(Scan& out, std::size_t at, double x0, double x1, bool central) const {
    const double lo = std::max(x0, -0.5), hi = std::min(x1, box_.size.x() - 0.5);
    if (hi <= lo) return;
    const int first = static_cast<int>(std::floor(lo + 0.5));
    const int last = std::min(static_cast<int>(std::floor(hi + 0.5)), box_.size.x() - 1);
    if (first == last) {
      out.coverage[at + first] += static_cast<float>(hi - lo);
    } else {
      out.coverage[at + first] += static_cast<float>(first + 0.5 - lo);
      for (int i = first + 1; i < last; ++i) out.coverage[at + i] += 1;
      out.coverage[at + last] += static_cast<float>(hi - (last - 0.5));
    }
    if (central)
      for (int i = std::max(0, static_cast<int>(std::ceil(lo))); i < hi; ++i) out.inside[at + i] = 1;
  }

  const CellBox& box_;
  int rows_;
  std::vector<Crossing> crossings_;
};

}  // namespace

void scan_mesh(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const CellBox& box,
               int rows, Scan& out) {
  out.coverage.assign(box.count(), 0);
  out.inside.assign(box.count(), 0);
  Rows lines(box, rows);
  for (const auto& t : triangles) lines.add(vertices, t);
  lines.fill(out);
}

}  // namespace terrazzo
