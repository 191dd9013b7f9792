#include "nodes/sizes/load_profiles/profile_outlines.h"

#include <algorithm>
#include <cmath>

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

// Numbered along the contour, counterclockwise for those who look along y up.
Loop upright(Loop loop, double height) {
  for (Vec2& p : loop) p.y() = height - p.y();
  if (loop_area(loop) < 0) std::reverse(loop.begin(), loop.end());
  return loop;
}

// A loop inside of an odd number of the others is a hole.
bool is_hole(const std::vector<Loop>& loops, std::size_t k) {
  const Vec2 inside = (loops[k][0] + loops[k][1]) / 2;
  bool hole = false;
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (i != k && loop_contains(loops[i], inside)) hole = !hole;
  return hole;
}

// In pixels, y up.
Profile profile_of(const FileOutline& o, double height) {
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
  p.centroid = moment / p.area;
  return p;
}

// The number of positions of a profile's box in the picture is what its weight makes up for.
void weigh(const OutlineFile& all, const OutlineExtent& extent, Profile& p) {
  constexpr double kFirstCenter = 0.5;
  const Vec2 size(all.width, all.height), box = extent.high - extent.low;
  p.touches_border = extent.low.minCoeff() < kFirstCenter || (size - extent.high).minCoeff() < kFirstCenter;
  p.weight = p.touches_border ? 0 : size.prod() / (size - box).prod();
}

}  // namespace

bool is_outline_json(const std::string& text) {
  return text.find("\"annotations\"") != std::string::npos ||
         text.find("\"coordinates\"") != std::string::npos ||
         text.find("\"FeatureCollection\"") != std::string::npos;
}

Profiles profiles_of_outlines(const OutlineFile& given, double pixel_size, const std::string& file,
                              const Reading& reading) {
  OutlineFile all = given;
  const bool known = all.width > 0;
  OutlineExtent extent;
  for (const FileOutline& o : all.outlines)
    for (const Loop& loop : o.loops) extent.add(loop);
  if (!known) {  // a picture that the outlines just fit in
    const Vec2 size = extent.high.array().ceil().min(1e6);
    all.width = std::max(1, static_cast<int>(size.x()));
    all.height = std::max(1, static_cast<int>(size.y()));
  }
  require_memory(8.0 * all.width * all.height * all.sections, reading.memory, "the pixels of '" + file + "'");
  raster_of(all, file);
  Profiles out;
  out.sections = all.sections;
  double area = 0;
  for (const FileOutline& o : all.outlines) {
    Profile p = profile_of(o, all.height);
    OutlineExtent own;
    for (const Loop& loop : o.loops) own.add(loop);
    if (known) weigh(all, own, p);
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
