#include "nodes/shapes/shape_sections/sections.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/data/indices.h"
#include "nodes/shapes/shape_sections/views.h"

namespace terrazzo::shape_sections {

namespace {

// Covariance of the enclosed volume about its centroid.
Mat3 covariance(const Mesh& mesh, const Vec3& center) {
  Mat3 sum = Mat3::Zero();
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - center, b = mesh.vertices[t[1]] - center,
               c = mesh.vertices[t[2]] - center;
    const double v = a.dot(b.cross(c)) / 6;
    const Vec3 s = a + b + c;
    sum += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    volume += v;
  }
  return sum / volume;
}

struct Extent {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  explicit Extent(const BodySection& section) {
    for (const auto& profile : section)
      for (const Vec2& p : profile[0]) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
  }
  Vec2 center() const { return (low + high) / 2; }
};

Vec2 centroid(const Loop& loop, double& area) {
  Vec2 first = Vec2::Zero();
  area = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 a = loop[i] - loop[0], b = loop[(i + 1) % loop.size()] - loop[0];
    const double c = (a.x() * b.y() - a.y() * b.x()) / 2;
    area += c;
    first += c * (a + b) / 3;
  }
  return area != 0 ? Vec2(loop[0] + first / area) : loop[0];
}

// Coverage of each pixel of a row, from crossings of sub-rows with the outlines; exact horizontally.
void cover_row(const BodySection& section, const Vec2& center, double scale, int cell, int y,
               std::vector<double>& cover) {
  constexpr int kRows = 8;
  std::fill(cover.begin(), cover.end(), 0);
  std::vector<double> at;
  for (int k = 0; k < kRows; ++k) {
    const double h = center.y() + (cell / 2.0 - y - (k + 0.5) / kRows) / scale;
    at.clear();
    for (const auto& profile : section)
      for (const Loop& loop : profile)
        for (std::size_t i = 0; i < loop.size(); ++i) {
          const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
          if ((a.y() > h) != (b.y() > h))
            at.push_back(cell / 2.0 +
                         scale * (a.x() + (h - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) - center.x()));
        }
    std::sort(at.begin(), at.end());
    for (std::size_t i = 0; i + 1 < at.size(); i += 2) {
      const double from = std::clamp<double>(at[i], 0.0, cell), to = std::clamp<double>(at[i + 1], 0.0, cell);
      for (int x = from; x < cell && x < to; ++x)
        cover[x] += std::max(0.0, std::min(to, x + 1.0) - std::max<double>(from, x)) / kRows;
    }
  }
}

}  // namespace

Mat3 volume_axes(const Mesh& mesh) {
  const auto solver = eigen_axes(covariance(mesh, mesh_centroid(mesh)));
  Mat3 axes = principal_axes(solver);
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return axes;
}

std::vector<BodySection> principal_sections(const Shapes& shapes) {
  std::vector<BodySection> out;
  for (const Shape& s : shapes.shapes) {
    const Vec3 center = mesh_centroid(s.mesh);
    const Mat3 axes = volume_axes(s.mesh);
    for (int k = 0; k < 3; ++k) {
      Mat3 frame;
      frame.col(0) = axes.col((k + 1) % 3);
      frame.col(2) = axes.col(k);
      frame.col(1) = frame.col(2).cross(frame.col(0));
      out.push_back(section_profiles(section_loops(s.mesh, frame, frame.col(2).dot(center))));
    }
  }
  return out;
}

double largest_extent(const std::vector<BodySection>& sections) {
  double most = 0;
  for (const auto& s : sections)
    if (!s.empty()) {
      const Extent e(s);
      most = std::max(most, (e.high - e.low).maxCoeff());
    }
  return most;
}

Profiles profiles_of(const std::vector<BodySection>& sections, int columns, double pitch) {
  Profiles out;
  const int rows = (count_of(sections) + columns - 1) / columns;
  out.window = pitch * Vec2(columns, rows);
  out.observed_area = out.window.prod();
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (sections[i].empty()) continue;
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const Vec2 move = pitch * Vec2(column + 0.5, rows - row - 0.5) - Extent(sections[i]).center();
    for (const auto& profile : sections[i]) {
      Profile p;
      p.centroid = centroid(profile[0], p.area) + move;
      for (std::size_t k = 1; k < profile.size(); ++k) p.area += loop_area(profile[k]);
      for (const Vec2& q : profile[0]) p.contour.push_back(q + move);
      out.area_fraction += p.area / out.observed_area;
      out.profiles.push_back(std::move(p));
    }
  }
  out.binder_color = Vec3f::Ones();
  return out;
}

Image picture_of(const std::vector<BodySection>& sections, int columns, int cell, double pixels_per_mm,
                 const Work& work) {
  const int rows = (count_of(sections) + columns - 1) / columns;
  Image image(columns * cell, rows * cell, 1, 1 / pixels_per_mm, Vec3f::Ones());
  work.parallel(sections.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<double> cover(cell);
    for (std::size_t i = begin; i < end; ++i) {
      if (sections[i].empty()) continue;
      const Vec2 center = Extent(sections[i]).center();
      const int left = static_cast<int>(i) % columns * cell, top = static_cast<int>(i) / columns * cell;
      for (int y = 0; y < cell; ++y) {
        work.check();
        cover_row(sections[i], center, pixels_per_mm, cell, y, cover);
        for (int x = 0; x < cell; ++x)
          image.at(left + x, top + y) = Vec3f::Constant(static_cast<float>(1 - cover[x]));
      }
    }
  });
  return image;
}

}  // namespace terrazzo::shape_sections
