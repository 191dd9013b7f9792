// Outlines of known shape, as from a perfect segmentation.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/data/profiles.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate::test {

using Contour = std::vector<Vec2>;

inline Contour ellipse(double a, double b, int n = 200, const Vec2& at = Vec2::Zero(), double turn = 0) {
  Contour c;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n, x = a * std::cos(t), y = b * std::sin(t);
    c.push_back(at + Vec2(x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn)));
  }
  return c;
}

inline Contour rectangle(double a, double b) { return {{0, 0}, {a, 0}, {a, b}, {0, b}}; }

// exp of a random Fourier series of the harmonics 2 to 5: star-shaped, rougher with larger `amplitude`.
inline Contour random_star(Random& r, double amplitude, int n = 200) {
  double a[6], b[6];
  for (int k = 2; k < 6; ++k) {
    a[k] = amplitude * r.normal() / k;
    b[k] = amplitude * r.normal() / k;
  }
  Contour c;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n;
    double f = 0;
    for (int k = 2; k < 6; ++k) f += a[k] * std::cos(k * t) + b[k] * std::sin(k * t);
    c.push_back(std::exp(f) * Vec2(std::cos(t), std::sin(t)));
  }
  return c;
}

// A bent band, not star-shaped about any point if `bend` (radians) exceeds about 1.5.
inline Contour banana(double length, double width, double bend, int n = 200) {
  Contour c;
  for (const Vec2& p : ellipse(length / 2, width / 2, n)) {
    const double radius = length / bend, angle = p.x() / radius;
    c.push_back({(radius + p.y()) * std::sin(angle), (radius + p.y()) * std::cos(angle) - radius});
  }
  return c;
}

// The outline of the pixels whose centers are inside, in steps of one pixel.
inline Contour pixelated(const Contour& c, double pixel) {
  // Walks along the boundary of a filled grid; its corners are the points.
  Vec2 low = c[0], high = c[0];
  for (const auto& p : c) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const int w = static_cast<int>((high.x() - low.x()) / pixel) + 3,
            h = static_cast<int>((high.y() - low.y()) / pixel) + 3;
  const auto inside = [&](int i, int j) {
    const Vec2 p = low + Vec2(i - 0.5, j - 0.5) * pixel;
    bool in = false;
    for (std::size_t k = 0; k < c.size(); ++k) {
      const Vec2 &a = c[k], &b = c[(k + 1) % c.size()];
      if ((a.y() > p.y()) != (b.y() > p.y()) &&
          p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        in = !in;
    }
    return in;
  };
  std::vector<std::vector<bool>> grid(w + 1, std::vector<bool>(h + 1));
  for (int i = 0; i <= w; ++i)
    for (int j = 0; j <= h; ++j) grid[i][j] = inside(i, j);
  const auto filled = [&](int i, int j) { return i >= 0 && j >= 0 && i <= w && j <= h && grid[i][j]; };
  int x = 0, y = 0;
  for (bool found = false; y <= h && !found; ++y)
    for (x = 0; x <= w && !found; ++x) found = filled(x, y);
  --x, --y;
  if (!filled(x, y)) return {};
  // Corner (x, y) is the lower left of pixel (x, y); the inside is on the left.
  Contour out;
  int dx = 1, dy = 0, cx = x, cy = y;
  do {
    out.push_back(low + Vec2(cx - 1, cy - 1) * pixel);
    cx += dx;
    cy += dy;
    // Whether the pixel ahead on a side of the current corner is filled.
    const auto ahead = [&](int side) {
      const int ax = dx + side * -dy, ay = dy + side * dx;  // diagonal ahead, side +1: left
      return filled(cx + (ax > 0 ? 0 : -1), cy + (ay > 0 ? 0 : -1));
    };
    if (ahead(-1) && ahead(1)) {
      const int t = dx;
      dx = dy, dy = -t;  // inside ahead on both sides: turn right
    } else if (!ahead(1)) {
      const int t = dx;
      dx = -dy, dy = t;  // outside ahead on the left: turn left
    }
  } while (cx != x || cy != y);
  return out;
}

// Numbered from 1. `crease`: degrees, as in make_outline.
inline std::vector<Outline> outlines_of(const std::vector<Contour>& contours, double crease) {
  std::vector<Outline> out;
  for (const auto& c : contours) out.push_back(make_outline(static_cast<int>(out.size()) + 1, c, crease));
  return out;
}

inline Profiles profiles_of(const std::vector<Contour>& contours) {
  Profiles p;
  for (const auto& c : contours) {
    Profile q;
    q.contour = c;
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Vec2 &a = c[i], &b = c[(i + 1) % c.size()];
      q.area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    p.profiles.push_back(q);
  }
  return p;
}

}  // namespace terrazzo::shape_estimate::test
