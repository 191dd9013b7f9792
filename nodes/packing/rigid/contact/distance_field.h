// Signed distance to one shape's surface, fast enough for millions of samples per second; negative inside, in
// the shape's own frame and mm. Three forms: a sphere, the face planes of a convex polyhedron (exact inside,
// a lower bound outside), and an interpolated regular grid of exact distances.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::packing {

// Whether a mesh is a sphere about the origin, within 1.5 % of its radius.
bool is_sphere(const Mesh& mesh);

class DistanceField {
 public:
  enum class Kind { Sphere, Planes, Grid };

  // A sphere if the mesh is one within 1.5 % of its radius (the circumscribed one), planes if it is convex
  // with at most 40 distinct faces, otherwise a grid of about cells³ over the mesh's volume.
  static DistanceField of(const Mesh& mesh, int cells, const Work& work = {});
  // Interpolation rounds sharp edges. Lowers the grid around these surface points until none
  // of them is outside.
  void include(const std::vector<Vec3>& points);

  Kind kind() const { return kind_; }
  float radius() const { return radius_; }  // of a sphere

  float value(const float* p) const {
    float unused[3];
    return sample<false>(p, unused);
  }
  // Also returns the gradient, of about unit length.
  float value(const float* p, float* gradient) const { return sample<true>(p, gradient); }

 private:
  template <bool WithGradient>
  float sample(const float* p, float* g) const;
  template <bool WithGradient>
  float sample_grid(const float* p, float* g) const;

  Kind kind_ = Kind::Grid;
  float radius_ = 0;
  std::vector<float> nx_, ny_, nz_, offset_;  // planes, n·x = offset
  float origin_[3] = {0, 0, 0}, cell_ = 1, inverse_cell_ = 1, pad_ = 0;
  int n_[3] = {0, 0, 0};
  std::vector<float> grid_;

  bool make_sphere(const Mesh&);
  bool make_planes(const Mesh&);
  void make_grid(const Mesh&, int cells, const Work&);
};

template <bool WithGradient>
float DistanceField::sample(const float* p, float* g) const {
  if (kind_ == Kind::Grid) return sample_grid<WithGradient>(p, g);
  if (kind_ == Kind::Sphere) {
    const float d = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    if constexpr (WithGradient) {
      const float s = d > 1e-12f ? 1 / d : 0;
      g[0] = d > 1e-12f ? p[0] * s : 1;
      g[1] = p[1] * s;
      g[2] = p[2] * s;
    }
    return d - radius_;
  }
  float best = -1e30f;
  std::size_t at = 0;
  for (std::size_t k = 0; k < offset_.size(); ++k) {
    const float v = nx_[k] * p[0] + ny_[k] * p[1] + nz_[k] * p[2] - offset_[k];
    if (v > best) {
      best = v;
      at = k;
    }
  }
  if constexpr (WithGradient) {
    g[0] = nx_[at];
    g[1] = ny_[at];
    g[2] = nz_[at];
  }
  return best;
}

template <bool WithGradient>
float DistanceField::sample_grid(const float* p, float* g) const {
  float u[3], outside = 0;
  bool in = true;
  for (int a = 0; a < 3; ++a) {
    u[a] = (p[a] - origin_[a]) * inverse_cell_;
    const float top = n_[a] - 1;
    if (!(u[a] >= 0 && u[a] < top)) {
      in = false;
      const float e = u[a] < 0 ? -u[a] : std::max(u[a] - top, 0.f);
      outside += e * e;
    }
  }
  if (!in) {  // a lower bound: the mesh is at least pad_ away from the grid's border
    if constexpr (WithGradient) {
      const float d = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + 1e-20f;
      for (int a = 0; a < 3; ++a) g[a] = p[a] / d;
    }
    return pad_ + std::sqrt(outside) * cell_;
  }
  const int i = static_cast<int>(u[0]), j = static_cast<int>(u[1]), k = static_cast<int>(u[2]);
  const float x = u[0] - static_cast<float>(i), y = u[1] - static_cast<float>(j),
              z = u[2] - static_cast<float>(k);
  const float* c = &grid_[(static_cast<std::size_t>(k) * n_[1] + j) * n_[0] + i];
  const std::size_t sy = n_[0], sz = static_cast<std::size_t>(n_[0]) * n_[1];
  const float x00 = c[0] + x * (c[1] - c[0]), x10 = c[sy] + x * (c[sy + 1] - c[sy]);
  const float x01 = c[sz] + x * (c[sz + 1] - c[sz]), x11 = c[sz + sy] + x * (c[sz + sy + 1] - c[sz + sy]);
  const float y0 = x00 + y * (x10 - x00), y1 = x01 + y * (x11 - x01);
  if constexpr (WithGradient) {
    const float dx0 = (c[1] - c[0]) + y * ((c[sy + 1] - c[sy]) - (c[1] - c[0]));
    const float dx1 = (c[sz + 1] - c[sz]) + y * ((c[sz + sy + 1] - c[sz + sy]) - (c[sz + 1] - c[sz]));
    g[0] = (dx0 + z * (dx1 - dx0)) * inverse_cell_;
    g[1] = ((x10 - x00) + z * ((x11 - x01) - (x10 - x00))) * inverse_cell_;
    g[2] = (y1 - y0) * inverse_cell_;
  }
  return y0 + z * (y1 - y0);
}

}  // namespace terrazzo::packing
