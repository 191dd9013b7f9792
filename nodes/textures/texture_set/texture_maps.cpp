#include "nodes/textures/texture_set/texture_maps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/bodies/cutting/soften.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/detail/residual/picture_detail.h"

namespace terrazzo::texture_set {
namespace {

using Point = FinishedSurface::Point;

class Painter {
 public:
  Painter(const FinishedSurface& surface, const Particles& particles, const section::SectionLayout& layout,
          const Roughness& roughness)
      : surface_(surface),
        particles_(particles),
        roughness_(roughness),
        width_(layout.pixels_x),
        height_(layout.pixels_y),
        mm_x_(layout.width / layout.pixels_x),
        mm_y_(layout.height / layout.pixels_y),
        plane_(layout.planes.at(0)) {
    const std::size_t count = pixels_in(width_, height_);
    out_.base_color = Image(width_, height_, 1, layout.pixel_size);
    out_.roughness = out_.base_color;
    out_.id = out_.base_color;
    out_.height = {width_, height_, mm_x_, mm_y_, std::vector<float>(count)};
    owner_.assign(count, -1);
    cover_.assign(count, 0.0f);
    ids_.assign(count, 0);
  }

  TextureMaps paint(const residual::ResidualField* detail, double softness, const Work& work) {
    take_centers(work.part(0, 0.4));
    average_edges(work.part(0.4, 0.8));
    if (detail) add_detail(*detail, softness, work);
    return std::move(out_);
  }

 private:
  Point point(int x, int row, double right, double up) const {
    return surface_.at((x + right) * mm_x_, (height_ - 1 - row + up) * mm_y_);
  }
  const Vec3f& color(int particle) const {
    return particle < 0 ? particles_.binder_color : particles_.color[particle];
  }
  float roughness(const Point& p) const {
    if (!p.worn) return p.particle < 0 ? Roughness::kNaturalBinder : Roughness::kNaturalParticle;
    if (p.particle < 0) return roughness_.binder;
    return static_cast<float>(roughness_.of_class(particles_.cls[p.particle]));
  }

  void take_centers(const Work& work) {
    work.parallel(height_, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row)
        for (int x = 0; x < width_; ++x) {
          const std::size_t at = row * width_ + x;
          const Point p = point(x, static_cast<int>(row), 0.5, 0.5);
          owner_[at] = p.particle;
          ids_[at] = p.particle + 1;
          cover_[at] = p.particle < 0 ? 0.0f : 1.0f;
          out_.height.mm[at] = p.height;
          out_.base_color.pixels[at] = color(p.particle);
          out_.roughness.pixels[at].setConstant(roughness(p));
          out_.id.pixels[at] = id_color(p.particle);
        }
    });
  }

  // Whether the texel to the right or below shows another particle or lies beyond a step of four texels.
  bool differs(std::size_t a, std::size_t b, double distance) const {
    return ids_[a] != ids_[b] ||
           std::abs(out_.height.mm[a] - out_.height.mm[b]) > static_cast<float>(distance);
  }
  std::vector<std::uint8_t> edges() const {
    std::vector<std::uint8_t> edge(ids_.size(), 0);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const std::size_t at = pixel_at(x, y, width_);
        const std::size_t right = pixel_at(wrap_index(x + 1, width_), y, width_);
        const std::size_t below = pixel_at(x, wrap_index(y + 1, height_), width_);
        if (differs(at, right, 4 * mm_x_)) edge[at] = edge[right] = 1;
        if (differs(at, below, 4 * mm_y_)) edge[at] = edge[below] = 1;
      }
    return edge;
  }

  void average_edges(const Work& work) {
    const std::vector<std::uint8_t> edge = edges();
    work.parallel(height_, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row)
        for (int x = 0; x < width_; ++x)
          if (edge[row * width_ + x]) average(x, static_cast<int>(row));
    });
  }

  void average(int x, int row) {
    constexpr int kSide = 4, kAll = kSide * kSide;
    const std::size_t at = pixel_at(x, row, width_);
    std::array<std::int32_t, kAll> seen;
    Vec3f sum = Vec3f::Zero();
    double height = 0, rough = 0;
    int covered = 0;
    for (int k = 0; k < kAll; ++k) {
      const Point p = point(x, row, (k % kSide + 0.5) / kSide, (k / kSide + 0.5) / kSide);
      seen[k] = p.particle;
      sum += color(p.particle);
      height += double{p.height};
      rough += double{roughness(p)};
      covered += p.particle >= 0;
    }
    out_.base_color.pixels[at] = sum / kAll;
    out_.height.mm[at] = static_cast<float>(height / kAll);
    out_.roughness.pixels[at].setConstant(static_cast<float>(rough / kAll));
    cover_[at] = static_cast<float>(covered) / kAll;
    std::sort(seen.begin(), seen.end());
    std::ptrdiff_t most = 0;
    for (auto first = std::upper_bound(seen.begin(), seen.end(), -1); first != seen.end();) {
      const auto last = std::upper_bound(first, seen.end(), *first);
      if (last - first > most) {
        most = last - first;
        owner_[at] = *first;
      }
      first = last;
    }
  }

  void add_detail(const residual::ResidualField& detail, double softness, const Work& work) {
    section::soften(out_.base_color.pixels.data(), cover_.data(), {width_, height_, mm_x_, mm_y_, true},
                    softness / mm_x_);
    residual::PicturePlane plane{
        width_, height_, mm_x_, mm_y_, true, plane_.origin, plane_.frame.col(0), plane_.frame.col(1)};
    plane.above = out_.height.mm;
    residual::add_to_picture(out_.base_color.pixels.data(), plane, ids_, owner_, cover_, detail, work);
  }

  const FinishedSurface& surface_;
  const Particles& particles_;
  const Roughness& roughness_;
  int width_, height_;
  double mm_x_, mm_y_;
  section::SectionPlane plane_;
  TextureMaps out_;
  std::vector<std::int32_t> owner_;  // particle with the largest share of the texel; −1: none
  std::vector<std::int32_t> ids_;    // particle at the center, from 1; 0: binder
  std::vector<float> cover_;         // share of all particles
};

}  // namespace

TextureMaps paint_maps(const FinishedSurface& surface, const Particles& particles,
                       const section::SectionLayout& layout, const Roughness& roughness,
                       const residual::ResidualField* detail, double softness, const Work& work) {
  return Painter(surface, particles, layout, roughness).paint(detail, softness, work);
}

}  // namespace terrazzo::texture_set
