#include "nodes/photograph/segment/measure/measure.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "nodes/common/geometry/components.h"
#include "nodes/common/texture/color_medians.h"
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
  std::vector<std::int32_t> core(static_cast<std::size_t>(W) * H, 0);
  for (int y = 1; y + 1 < H; ++y)
    for (int x = 1; x + 1 < W; ++x) {
      bool all = true;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          all = all && undecided[first + static_cast<std::size_t>(v) * W + u];
      core[static_cast<std::size_t>(y) * W + x] = all;
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
          near = std::max(near, parts.ids[static_cast<std::size_t>(v) * W + u]);
      if (near > 0) ++area[static_cast<std::size_t>(near) - 1];
    }
  for (std::size_t k = 0; k < area.size(); ++k)
    if (parts.sizes[k] >= kLeast)
      out.fragments.push_back({colors.value(k), image.pixel_size * image.pixel_size * area[k]});
}

}  // namespace

Profiles measure_profiles(const Image& image, const Labels& labels, const std::vector<float>& coverage,
                          const IgnoredPixels& ignored, const UndecidedPixels& undecided, const Work& work) {
  const int W = labels.width, H = labels.height;
  const double s = labels.pixel_size;
  const std::size_t section_size = static_cast<std::size_t>(W) * H;
  Profiles out;
  out.sections = labels.sections;
  out.window = s * Vec2(W, H);
  const auto seen =
      static_cast<double>(section_size * labels.sections) - std::count(ignored.begin(), ignored.end(), 1);
  const double decided = seen - std::count(undecided.begin(), undecided.end(), 1);
  out.observed_area = s * s * decided;
  Eigen::Vector3d binder = Eigen::Vector3d::Zero();
  std::int64_t binder_pixels = 0;
  for (int section = 0; section < labels.sections; ++section) {
    const std::size_t first = section_size * section;
    // Ids run through all sections; here they are renumbered from 1 within the section.
    std::int32_t low = 0x7fffffff, high = 0;
    for (std::size_t i = first; i < first + section_size; ++i)
      if (labels.ids[i] > 0) {
        low = std::min(low, labels.ids[i]);
        high = std::max(high, labels.ids[i]);
      }
    const int count = high == 0 ? 0 : high - low + 1;
    const std::span<const std::int32_t> ids(labels.ids.data() + first, section_size);
    const auto deep = [&](int x, int y) {  // more than one pixel inside
      const std::int32_t id = ids[static_cast<std::size_t>(y) * W + x];
      for (int v = std::max(0, y - 1); v <= std::min(H - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(W - 1, x + 1); ++u)
          if (ids[static_cast<std::size_t>(v) * W + u] != id) return false;
      return true;
    };
    std::vector<Sums> sums(count);
    for (int y = 0; y < H; ++y)
      for (int x = 0; x < W; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * W + x;
        const Eigen::Vector3d c = image.pixels[first + i].cast<double>();
        if (ids[i] == 0) {
          if (!ignored.empty() && ignored[first + i]) continue;
          if (!undecided.empty() && undecided[first + i]) continue;
          binder += c;
          ++binder_pixels;
          continue;
        }
        Sums& p = sums[ids[i] - low];
        ++p.pixels;
        if (deep(x, y)) ++p.core_pixels;
        p.left = std::min(p.left, x);
        p.right = std::max(p.right, x);
        p.top = std::min(p.top, y);
        p.bottom = std::max(p.bottom, y);
      }
    work.check();
    // Colors of the cores, or of whole profiles without a core.
    std::vector<std::int64_t> used;
    for (const Sums& p : sums) used.push_back(p.core_pixels > 0 ? p.core_pixels : p.pixels);
    ColorMedians colors(std::move(used));
    for (int y = 0; y < H; ++y)
      for (int x = 0; x < W; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * W + x;
        if (ids[i] == 0) continue;
        const std::size_t k = ids[i] - low;
        if (sums[k].core_pixels == 0 || deep(x, y)) colors.add(k, image.pixels[first + i]);
      }
    work.check();
    if (!undecided.empty()) add_fragments(image, undecided, first, out);
    std::optional<Positions> positions;
    if (!ignored.empty()) positions.emplace(ignored.data() + first, W, H);
    auto lines = outlines(ids, std::span(coverage).subspan(first, section_size), W, H, count, work, low);
    std::map<std::pair<int, int>, std::int64_t> places;  // for boxes of this size
    const auto count_places = [&](int w, int h) {
      const auto [it, added] = places.try_emplace({w, h}, 0);
      if (added) {
        work.check();
        it->second = positions->count(w, h);
      }
      return static_cast<double>(it->second);
    };
    for (int k = 0; k < count; ++k) {
      const Sums& sum = sums[k];
      if (sum.pixels == 0) continue;
      Profile p;
      p.section = section;
      p.cls = labels.classes[low + k - 1];
      p.area = lines[k].area * s * s;
      p.centroid = lines[k].centroid * s;
      const int w = sum.right - sum.left + 1, h = sum.bottom - sum.top + 1;
      p.touches_border = sum.left == 0 || sum.top == 0 || sum.right == W - 1 || sum.bottom == H - 1 ||
                         (positions && !positions->contains(sum.left, sum.top, w, h));
      if (p.touches_border)
        p.weight = 0;
      else if (positions)
        p.weight = seen / labels.sections / count_places(w, h);
      else
        p.weight = static_cast<double>(W) * H / (static_cast<double>(W - w - 1) * (H - h - 1));
      p.color = colors.value(k);
      p.contour = std::move(lines[k].points);
      for (auto& q : p.contour) q *= s;
      out.classes = std::max(out.classes, p.cls + 1);
      out.profiles.push_back(std::move(p));
    }
  }
  if (binder_pixels > 0) out.binder_color = (binder / static_cast<double>(binder_pixels)).cast<float>();
  out.area_fraction = decided > 0 ? 1 - binder_pixels / decided : 0;
  return out;
}

}  // namespace terrazzo::segment
