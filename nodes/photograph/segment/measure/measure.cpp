#include "nodes/photograph/segment/measure/measure.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "nodes/common/geometry/components.h"
#include "nodes/common/texture/color_medians.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/outline/outline.h"

namespace terrazzo::segment {
namespace {

struct Sums {
  std::int64_t core_pixels = 0, pixels = 0;
  int left = 1 << 30, top = 1 << 30, right = -1, bottom = -1;
};

// The connected undecided places of one section, by the pixels that have only such neighbors: at the edge of
// a place, colors are mixed with those of particles.
void add_fragments(const Image& image, const UndecidedPixels& undecided, std::size_t first, Profiles& out) {
  constexpr std::int64_t kLeast = 6;  // pixels
  const int W = image.width, H = image.height;
  std::vector<std::int32_t> core(pixels_in(W, H), 0);
  for (int y = 1; y + 1 < H; ++y)
    for (int x = 1; x + 1 < W; ++x) {
      bool all = true;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) all = all && undecided[first + pixel_at(u, v, W)];
      core[pixel_at(x, y, W)] = all;
    }
  const Components parts = connected_components(core, W, H, true);
  ColorMedians colors(std::vector<std::int64_t>(parts.sizes.begin(), parts.sizes.end()));
  for (std::size_t i = 0; i < core.size(); ++i)
    if (const auto k = parts.ids[i]; k > 0)
      colors.add(static_cast<std::size_t>(k) - 1, image.pixels[first + i]);
  std::vector<std::int64_t> area(parts.sizes.size(), 0);  // with the pixels around
  for (int y = 0; y < H; ++y)
    for (int x = 0; x < W; ++x) {
      std::int32_t near = 0;
      for (int v = std::max(0, y - 1); v <= std::min(H - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(W - 1, x + 1); ++u)
          near = std::max(near, parts.ids[pixel_at(u, v, W)]);
      if (near > 0) ++area[near - 1];
    }
  for (std::size_t k = 0; k < area.size(); ++k)
    if (parts.sizes[k] >= kLeast)
      out.fragments.push_back({colors.value(k), image.pixel_size * image.pixel_size * area[k]});
}

// The labels of one section. Ids run through all sections; here they count from `low` of the section.
struct SectionLabels {
  std::span<const std::int32_t> ids;
  int width, height;
  std::int32_t low = 0x7fffffff;
  int count = 0;

  SectionLabels(const Labels& labels, std::size_t first, std::size_t pixels)
      : ids(labels.ids.data() + first, pixels), width(labels.width), height(labels.height) {
    std::int32_t high = 0;
    for (const std::int32_t id : ids)
      if (id > 0) {
        low = std::min(low, id);
        high = std::max(high, id);
      }
    count = high == 0 ? 0 : high - low + 1;
  }

  // More than one pixel inside.
  bool deep(int x, int y) const {
    const std::int32_t id = ids[pixel_at(x, y, width)];
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
        if (ids[pixel_at(u, v, width)] != id) return false;
    return true;
  }
};

struct BinderSum {
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  std::int64_t pixels = 0;
};

// Sums of each profile; pixels outside are added to the binder.
std::vector<Sums> sum_pixels(const SectionLabels& section, const Image& image, std::size_t first,
                             const IgnoredPixels& ignored, const UndecidedPixels& undecided,
                             BinderSum& binder) {
  std::vector<Sums> sums(section.count);
  for (int y = 0; y < section.height; ++y)
    for (int x = 0; x < section.width; ++x) {
      const std::size_t i = pixel_at(x, y, section.width);
      if (section.ids[i] == 0) {
        if (!ignored.empty() && ignored[first + i]) continue;
        if (!undecided.empty() && undecided[first + i]) continue;
        binder.color += image.pixels[first + i].cast<double>();
        ++binder.pixels;
        continue;
      }
      Sums& p = sums[section.ids[i] - section.low];
      ++p.pixels;
      if (section.deep(x, y)) ++p.core_pixels;
      p.left = std::min(p.left, x);
      p.right = std::max(p.right, x);
      p.top = std::min(p.top, y);
      p.bottom = std::max(p.bottom, y);
    }
  return sums;
}

// Colors of the cores, or of whole profiles without a core.
ColorMedians core_colors(const SectionLabels& section, const std::vector<Sums>& sums, const Image& image,
                         std::size_t first) {
  std::vector<std::int64_t> used;
  for (const Sums& p : sums) used.push_back(p.core_pixels > 0 ? p.core_pixels : p.pixels);
  ColorMedians colors(std::move(used));
  for (int y = 0; y < section.height; ++y)
    for (int x = 0; x < section.width; ++x) {
      const std::size_t i = pixel_at(x, y, section.width);
      if (section.ids[i] == 0) continue;
      const std::size_t k = section.ids[i] - section.low;
      if (sums[k].core_pixels == 0 || section.deep(x, y)) colors.add(k, image.pixels[first + i]);
    }
  return colors;
}

// Where a profile could lie within the section without touching its border or ignored pixels.
class ProfilePlaces {
 public:
  // `ignored`: of the section, or null. `seen`: pixels of a section that are not ignored, on average.
  ProfilePlaces(const std::uint8_t* ignored, int width, int height, double seen, const Work& work)
      : width_(width), height_(height), seen_(seen), work_(work) {
    if (ignored) positions_.emplace(ignored, width, height);
  }

  // Sets whether the profile touches the border, and its weight.
  void weigh(const Sums& sum, Profile& p) {
    const int w = sum.right - sum.left + 1, h = sum.bottom - sum.top + 1;
    p.touches_border = sum.left == 0 || sum.top == 0 || sum.right == width_ - 1 ||
                       sum.bottom == height_ - 1 ||
                       (positions_ && !positions_->contains(sum.left, sum.top, w, h));
    if (p.touches_border)
      p.weight = 0;
    else if (positions_)
      p.weight = seen_ / count(w, h);
    else
      p.weight =
          static_cast<double>(width_) * height_ / (static_cast<double>(width_ - w - 1) * (height_ - h - 1));
  }

 private:
  double count(int w, int h) {
    const auto [it, added] = counts_.try_emplace({w, h}, 0);
    if (added) {
      work_.check();
      it->second = positions_->count(w, h);
    }
    return it->second;
  }

  int width_, height_;
  double seen_;
  const Work& work_;
  std::optional<Positions> positions_;
  std::map<std::pair<int, int>, std::int64_t> counts_;  // for boxes of this size
};

}  // namespace

Profiles measure_profiles(const Image& image, const Labels& labels, const std::vector<float>& coverage,
                          const IgnoredPixels& ignored, const UndecidedPixels& undecided, const Work& work) {
  const int W = labels.width, H = labels.height;
  const double s = labels.pixel_size;
  const std::size_t section_size = pixels_in(W, H);
  Profiles out;
  out.sections = labels.sections;
  out.window = s * Vec2(W, H);
  const auto seen =
      static_cast<double>(section_size * labels.sections) - std::count(ignored.begin(), ignored.end(), 1);
  const double decided = seen - std::count(undecided.begin(), undecided.end(), 1);
  out.observed_area = s * s * decided;
  BinderSum binder;
  for (int number = 0; number < labels.sections; ++number) {
    const std::size_t first = section_size * number;
    const SectionLabels section(labels, first, section_size);
    const std::vector<Sums> sums = sum_pixels(section, image, first, ignored, undecided, binder);
    work.check();
    ColorMedians colors = core_colors(section, sums, image, first);
    work.check();
    if (!undecided.empty()) add_fragments(image, undecided, first, out);
    ProfilePlaces places(ignored.empty() ? nullptr : ignored.data() + first, W, H, seen / labels.sections,
                         work);
    auto lines = outlines(section.ids, std::span(coverage).subspan(first, section_size), W, H, section.count,
                          work, section.low);
    for (int k = 0; k < section.count; ++k) {
      if (sums[k].pixels == 0) continue;
      Profile p;
      p.section = number;
      p.cls = labels.classes[section.low + k - 1];
      p.area = lines[k].area * s * s;
      p.centroid = lines[k].centroid * s;
      places.weigh(sums[k], p);
      p.color = colors.value(k);
      p.contour = std::move(lines[k].points);
      for (auto& q : p.contour) q *= s;
      out.classes = std::max(out.classes, p.cls + 1);
      out.profiles.push_back(std::move(p));
    }
  }
  if (binder.pixels > 0) out.binder_color = (binder.color / static_cast<double>(binder.pixels)).cast<float>();
  out.area_fraction = decided > 0 ? 1 - binder.pixels / decided : 0;
  return out;
}

}  // namespace terrazzo::segment
