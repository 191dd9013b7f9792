#include "nodes/bodies/cutting/pixel_regions.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/data/indices.h"

namespace terrazzo::section {

namespace {

// Sums over a region's pixels. Positions are relative to its first pixel, by the shorter way around in a
// tile.
struct Sums {
  std::int32_t id = 0;
  int first_x = 0, first_y = 0;  // pixels, y up
  double count = 0, x = 0, y = 0;
  int min_x = 0, max_x = 0, min_y = 0, max_y = 0;
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
};

int short_way(int d, int n) { return d > n / 2 ? d - n : d < -(n / 2) ? d + n : d; }

// Joins neighbors of the same body. `value`: of each pixel, below 0 in the binder.
DisjointSets join_pixels(const std::int32_t* value, int w, int h, bool tile) {
  DisjointSets sets(pixels_in(w, h));
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::int32_t at = y * w + x;
      if (value[at] < 0) continue;
      const std::int32_t right = y * w + (x + 1) % w, below = (y + 1) % h * w + x;
      if ((x + 1 < w || tile) && value[right] == value[at]) sets.join(at, right);
      if ((y + 1 < h || tile) && value[below] == value[at]) sets.join(at, below);
    }
  return sets;
}

// Adds the pixel at dx, dy from the region's first.
void add_pixel(Sums& s, int dx, int dy, const Eigen::Vector3d& color) {
  ++s.count;
  s.x += dx;
  s.y += dy;
  s.color += color;
  s.min_x = std::min(s.min_x, dx);
  s.max_x = std::max(s.max_x, dx);
  s.min_y = std::min(s.min_y, dy);
  s.max_y = std::max(s.max_y, dy);
}

Profile region_profile(const Sums& s, const SectionLayout& layout) {
  const int w = layout.pixels_x, h = layout.pixels_y;
  const double mm_x = layout.width / w, mm_y = layout.height / h;
  Profile p;
  p.area = s.count * (mm_x * mm_y);
  p.centroid = {(s.first_x + s.x / s.count + 0.5) * mm_x, (s.first_y + s.y / s.count + 0.5) * mm_y};
  if (layout.tile) {
    p.centroid.x() -= std::floor(p.centroid.x() / layout.width) * layout.width;
    p.centroid.y() -= std::floor(p.centroid.y() / layout.height) * layout.height;
  } else {
    p.touches_border = s.first_x + s.min_x == 0 || s.first_y + s.min_y == 0 || s.first_x + s.max_x == w - 1 ||
                       s.first_y + s.max_y == h - 1;
    // A profile with at least one free pixel on either side fits in (w − 1 − its width) positions.
    const double places_x = w - 1 - (s.max_x - s.min_x + 1), places_y = h - 1 - (s.max_y - s.min_y + 1);
    p.weight = p.touches_border ? 0 : pixels_in(w, h) / (places_x * places_y);
  }
  p.color = (s.color / s.count).cast<float>();
  return p;
}

}  // namespace

void PixelRegions::measure(Section& out, bool classes, const Work& work) const {
  const int w = layout_.pixels_x, h = layout_.pixels_y, sections = layout_.planes.size();
  const std::size_t count = pixels_in(w, h);
  out.labels.width = w;
  out.labels.height = h;
  out.labels.sections = sections;
  out.labels.pixel_size = layout_.pixel_size;
  out.labels.ids.assign(image_.pixels.size(), 0);
  Profiles& profiles = out.profiles;
  profiles.sections = sections;
  profiles.window = {layout_.width, layout_.height};
  profiles.observed_area = layout_.window_area() * sections;
  out.table.columns = {"section", "particle", "class", "area mm²", "weight"};

  double inside = 0, outside = 0;
  Eigen::Vector3d binder = Eigen::Vector3d::Zero();
  for (int section = 0; section < sections; ++section) {
    work.check();
    const std::int32_t* value = values_.data() + section * count;
    DisjointSets sets = join_pixels(value, w, h, layout_.tile);
    std::vector<std::int32_t> index(count, -1);
    std::vector<Sums> regions;
    for (std::size_t at = 0; at < count; ++at) {
      const int x = static_cast<int>(at) % w, y = h - 1 - static_cast<int>(at) / w;
      const Eigen::Vector3d color = image_.pixels[section * count + at].cast<double>();
      if (value[at] < 0) {
        binder += color;
        ++outside;
        continue;
      }
      const std::int32_t root = sets.find(at);
      if (index[root] < 0) {
        index[root] = regions.size();
        Sums s;
        s.id = value[at];
        s.first_x = x;
        s.first_y = y;
        regions.push_back(s);
      }
      Sums& s = regions[index[root]];
      add_pixel(s, layout_.tile ? short_way(x - s.first_x, w) : x - s.first_x,
                layout_.tile ? short_way(y - s.first_y, h) : y - s.first_y, color);
      ++inside;
      out.labels.ids[section * count + at] =
          static_cast<std::int32_t>(profiles.profiles.size()) + index[root] + 1;
    }
    for (const Sums& s : regions) {
      Profile p = region_profile(s, layout_);
      p.section = section;
      p.cls = classes ? s.id : 0;
      profiles.classes = std::max(profiles.classes, p.cls + 1);
      out.labels.classes.push_back(p.cls);
      out.table.rows.push_back(
          {double(section), classes ? -1.0 : double(s.id), double(p.cls), p.area, p.weight});
      profiles.profiles.push_back(std::move(p));
    }
  }
  profiles.area_fraction = inside / (inside + outside);
  if (outside > 0) profiles.binder_color = (binder / outside).cast<float>();
}

}  // namespace terrazzo::section
