#include "nodes/sizes/load_profiles/profile_outlines.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/fill_loops.h"
#include "nodes/common/geometry/mesh/loop_moments.h"

namespace terrazzo::load_profiles {
namespace {

// Pixels, y down.
struct OutlineExtent {
  Vec2 low = Vec2::Constant(INFINITY), high = Vec2::Constant(-INFINITY);
  void add(const Loop& loop) {
    for (const Vec2& p : loop) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
};

// y up, counterclockwise.
Loop upright(Loop loop, double height) {
  for (Vec2& p : loop) p.y() = height - p.y();
  if (loop_area(loop) < 0) std::reverse(loop.begin(), loop.end());
  return loop;
}

// A point inside of a loop: the middle of its widest chord halfway up the highest strip between two corners.
Vec2 inside_of_loop(const Loop& loop) {
  std::vector<double> ends, x;
  for (const Vec2& p : loop) ends.push_back(p.y());
  std::sort(ends.begin(), ends.end());
  double y = ends[0], height = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i)
    if (ends[i + 1] - ends[i] > height) {
      height = ends[i + 1] - ends[i];
      y = (ends[i] + ends[i + 1]) / 2;
    }
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    if ((a.y() < y) != (b.y() < y)) x.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
  }
  std::sort(x.begin(), x.end());
  Vec2 out(loop[0].x(), y);
  double width = 0;
  for (std::size_t k = 0; k + 1 < x.size(); k += 2)
    if (x[k + 1] - x[k] > width) {
      width = x[k + 1] - x[k];
      out.x() = (x[k] + x[k + 1]) / 2;
    }
  return out;
}

// A loop inside of an odd number of larger ones is a hole. Loops do not cross, but may share sides. Of two
// equal ones, the second is a hole.
bool is_hole(const std::vector<Loop>& loops, std::size_t k) {
  if (loops.size() == 1) return false;
  const Vec2 inside = inside_of_loop(loops[k]);
  const double area = std::abs(loop_area(loops[k]));
  bool hole = false;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const double other = std::abs(loop_area(loops[i]));
    if ((other > area || (other == area && i < k)) && loop_contains(loops[i], inside)) hole = !hole;
  }
  return hole;
}

// In pixels, y up.
Profile profile_of(const FileOutline& o, double height, const std::string& file) {
  Profile p;
  p.section = o.section;
  p.cls = o.cls;
  p.confidence = o.confidence;
  double largest = 0;
  Vec2 moment = Vec2::Zero();
  for (std::size_t k = 0; k < o.loops.size(); ++k) {
    const Loop loop = upright(o.loops[k], height);
    const LoopMoments m = loop_moments(loop);
    if (!(m.area > 0)) continue;
    const double signed_area = is_hole(o.loops, k) ? -m.area : m.area;
    p.area += signed_area;
    moment += signed_area * m.center;
    if (signed_area > largest) {
      largest = signed_area;
      p.contour = loop;
    }
  }
  if (!(p.area > 0))
    throw bad_outline(file, o.name + " has no area: its holes are as large as its parts",
                      "repair the polygon in the program that made it");
  p.centroid = moment / p.area;
  return p;
}

// Of the pixels inside, as Profile::color says; black without any.
Vec3f color_of(const FileOutline& o, const Image& picture) {
  std::vector<float> values[3];
  fill_loops(o.loops, picture.width, picture.height, [&](int y, int begin, int end) {
    for (int x = begin; x < end; ++x)
      for (int k = 0; k < 3; ++k) values[k].push_back(picture.at(x, y, o.section)[k]);
  });
  Vec3f out = Vec3f::Zero();
  for (int k = 0; k < 3; ++k) {
    if (values[k].empty()) continue;
    const auto middle = values[k].begin() + static_cast<std::ptrdiff_t>(values[k].size() / 2);
    std::nth_element(values[k].begin(), middle, values[k].end());
    out[k] = *middle;
  }
  return out;
}

// As Profile::weight says, by the box around the outline.
void weigh(const OutlineFile& all, const OutlineExtent& extent, Profile& p) {
  constexpr double kFirstCenter = 0.5;
  const Vec2 size(all.width, all.height), box = extent.high - extent.low;
  p.touches_border = extent.low.minCoeff() < kFirstCenter || (size - extent.high).minCoeff() < kFirstCenter;
  p.weight = p.touches_border ? 0 : size.prod() / (size - box).prod();
}

}  // namespace

bool is_outline_json(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || (text[first] != '{' && text[first] != '[')) return false;
  return text.find("\"annotations\"") != std::string::npos ||
         text.find("\"coordinates\"") != std::string::npos ||
         text.find("\"FeatureCollection\"") != std::string::npos;
}

Profiles profiles_of_outlines(OutlineFile all, double pixel_size, const Image* picture,
                              const std::string& file, const Reading& reading, const Work& work) {
  const bool known = all.width > 0;
  if (!known) {  // a picture that the outlines just fit in
    OutlineExtent extent;
    for (const FileOutline& o : all.outlines)
      for (const Loop& loop : o.loops) extent.add(loop);
    all.width = std::max(1, static_cast<int>(std::ceil(extent.high.x())));
    all.height = std::max(1, static_cast<int>(std::ceil(extent.high.y())));
  }
  require_memory(4.0 * all.width * all.height, reading.memory, "the pixels of '" + file + "'");
  require_apart(all, file, work);
  Profiles out;
  out.sections = all.sections;
  double area = 0;
  for (const FileOutline& o : all.outlines) {
    work.check();
    Profile p = profile_of(o, all.height, file);
    OutlineExtent own;
    for (const Loop& loop : o.loops) own.add(loop);
    if (known) weigh(all, own, p);
    if (picture) p.color = color_of(o, *picture);
    p.area *= pixel_size * pixel_size;
    p.centroid *= pixel_size;
    for (Vec2& q : p.contour) q *= pixel_size;
    area += p.area;
    out.classes = std::max(out.classes, p.cls + 1);
    out.profiles.push_back(std::move(p));
  }
  if (!known) return out;
  out.window = pixel_size * Vec2(all.width, all.height);
  out.observed_area = out.window.prod() * all.sections;
  out.area_fraction = std::min(1.0, area / out.observed_area);
  return out;
}

}  // namespace terrazzo::load_profiles
