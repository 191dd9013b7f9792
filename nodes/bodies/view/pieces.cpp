#include "nodes/bodies/view/pieces.h"

#include <algorithm>

#include "nodes/common/geometry/components.h"
#include "nodes/common/stereology/silhouette.h"
#include "nodes/common/texture/color_medians.h"
#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

constexpr std::int64_t kLeastPixels = 12;

// The pixels of a piece; y is up.
struct Extents {
  int first_x = 0, first_row = 0;
  int min_x = 1 << 30, max_x = -1, min_y = 1 << 30, max_y = -1;
  double count = 0;
  Vec2 sum = Vec2::Zero();

  void add(int x, int row, int height) {
    const int y = height - 1 - row;
    if (count == 0) {
      first_x = x;
      first_row = row;
    }
    ++count;
    sum += Vec2(x + 0.5, y + 0.5);
    min_x = std::min(min_x, x);
    max_x = std::max(max_x, x);
    min_y = std::min(min_y, y);
    max_y = std::max(max_y, y);
  }
  bool touches_border(int width, int height) const {
    return min_x == 0 || min_y == 0 || max_x == width - 1 || max_y == height - 1;
  }
};

// Extents and colors of all components of one picture.
struct Measured {
  std::vector<Extents> extents;
  std::vector<Vec3f> colors;
};

Measured measure_components(const Components& components, const Image& image, int section) {
  Measured out;
  out.extents.resize(components.count());
  ColorMedians medians(components.sizes);
  for (int row = 0; row < image.height; ++row)
    for (int x = 0; x < image.width; ++x) {
      const std::int32_t id = components.ids[pixel_at(x, row, image.width)];
      if (id == 0) continue;
      out.extents[id - 1].add(x, row, image.height);
      medians.add(id - 1, image.at(x, row, section));
    }
  for (int k = 0; k < components.count(); ++k) out.colors.push_back(medians.value(k));
  return out;
}

Profile profile_of_piece(const Extents& e, const Components& components, const SurfaceOptions& options) {
  const int w = options.pixels_x;
  const int h = options.pixels_y;
  const Vec2 pixel(options.width / w, options.height / h);
  Profile p;
  p.area = e.count * pixel.prod();
  p.centroid = (e.sum / e.count).cwiseProduct(pixel);
  p.touches_border = e.touches_border(w, h);
  const double places_x = w - 1 - (e.max_x - e.min_x + 1);
  const double places_y = h - 1 - (e.max_y - e.min_y + 1);
  p.weight = p.touches_border ? 0 : pixels_in(w, h) / (places_x * places_y);
  p.contour = outline_of_pixels(components.ids, w, h, e.first_x, e.first_row);
  for (Vec2& v : p.contour) v = v.cwiseProduct(pixel);
  p.whole = std::max(p.area, whole_silhouette(p.contour));
  return p;
}

}  // namespace

void add_pieces(SurfaceView& out, int section, const std::vector<std::int32_t>& stone, const Bed& bed,
                const Particles& particles, const SurfaceOptions& options) {
  std::vector<std::int32_t> raster(stone.size());
  std::transform(stone.begin(), stone.end(), raster.begin(), [](std::int32_t s) { return s + 1; });
  const Components components =
      connected_components(raster, options.pixels_x, options.pixels_y, /*diagonal=*/false);
  const Measured measured = measure_components(components, out.image, section);
  std::vector<std::int32_t> number(components.count() + 1, 0);
  for (int k = 0; k < components.count(); ++k) {
    if (components.sizes[k] < kLeastPixels) continue;
    const int particle = bed.particle(components.values[k] - 1);
    Profile p = profile_of_piece(measured.extents[k], components, options);
    p.section = section;
    p.cls = particles.cls[particle];
    p.color = measured.colors[k];
    out.labels.classes.push_back(p.cls);
    out.table.rows.push_back({double(section), double(particle), double(p.cls), p.area,
                              loop_perimeter(p.contour), p.whole, p.weight});
    out.profiles.classes = std::max(out.profiles.classes, p.cls + 1);
    out.profiles.profiles.push_back(std::move(p));
    number[k + 1] = out.labels.count();
  }
  const std::size_t first = out.image.index(0, 0, section);
  for (std::size_t i = 0; i < stone.size(); ++i) out.labels.ids[first + i] = number[components.ids[i]];
}

}  // namespace terrazzo::view
