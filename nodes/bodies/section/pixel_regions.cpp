#include "nodes/bodies/section/pixel_regions.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/disjoint_sets.h"

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

}  // namespace

void PixelRegions::measure(Section& out, const Work& work) const {
  const int w = layout_.pixels_x, h = layout_.pixels_y, sections = layout_.planes.size();
  const double mm_x = layout_.width / w, mm_y = layout_.height / h, pixel = mm_x * mm_y;
  const std::size_t count = static_cast<std::size_t>(w) * h;
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
    DisjointSets sets(count);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::int32_t at = y * w + x;
        if (value[at] < 0) continue;
        const std::int32_t right = y * w + (x + 1) % w, below = (y + 1) % h * w + x;
        if ((x + 1 < w || layout_.tile) && value[right] == value[at]) sets.join(at, right);
        if ((y + 1 < h || layout_.tile) && value[below] == value[at]) sets.join(at, below);
      }
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
      const int dx = layout_.tile ? short_way(x - s.first_x, w) : x - s.first_x;
      const int dy = layout_.tile ? short_way(y - s.first_y, h) : y - s.first_y;
      ++s.count;
      s.x += dx;
      s.y += dy;
      s.color += color;
      ++inside;
      s.min_x = std::min(s.min_x, dx);
      s.max_x = std::max(s.max_x, dx);
      s.min_y = std::min(s.min_y, dy);
      s.max_y = std::max(s.max_y, dy);
      out.labels.ids[section * count + at] =
          static_cast<std::int32_t>(profiles.profiles.size()) + index[root] + 1;
    }
    for (const Sums& s : regions) {
      Profile p;
      p.section = section;
      p.area = s.count * pixel;
      p.centroid = {(s.first_x + s.x / s.count + 0.5) * mm_x, (s.first_y + s.y / s.count + 0.5) * mm_y};
      if (layout_.tile) {
        p.centroid.x() -= std::floor(p.centroid.x() / layout_.width) * layout_.width;
        p.centroid.y() -= std::floor(p.centroid.y() / layout_.height) * layout_.height;
      } else {
        p.touches_border = s.first_x + s.min_x == 0 || s.first_y + s.min_y == 0 ||
                           s.first_x + s.max_x == w - 1 || s.first_y + s.max_y == h - 1;
        // A profile with at least one free pixel on either side fits in (w − 1 − its width) positions.
        const double places_x = w - 1 - (s.max_x - s.min_x + 1), places_y = h - 1 - (s.max_y - s.min_y + 1);
        p.weight = p.touches_border ? 0 : count / (places_x * places_y);
      }
      p.color = (s.color / s.count).cast<float>();
      out.labels.classes.push_back(0);
      out.table.rows.push_back({double(section), double(s.id), 0.0, p.area, p.weight});
      profiles.profiles.push_back(p);
    }
  }
  profiles.area_fraction = inside / (inside + outside);
  if (outside > 0) profiles.binder_color = (binder / outside).cast<float>();
}

}  // namespace terrazzo::section
