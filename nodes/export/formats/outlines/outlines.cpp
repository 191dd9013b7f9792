#include "nodes/export/formats/outlines/outlines.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/profile_columns.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

// The center of the loop's first pixel in reading order, of which its first corner is the upper left one.
// Loops follow the edges of pixels.
Vec2 inside_of(const Loop& loop) {
  const Vec2 first = *std::min_element(loop.begin(), loop.end(), [](const Vec2& a, const Vec2& b) {
    return a.y() < b.y() || (a.y() == b.y() && a.x() < b.x());
  });
  return first + Vec2(0.5, 0.5);
}

}  // namespace

OutlineFile outlines_of(const Labels& labels) {
  OutlineFile out{.width = labels.width,
                  .height = labels.height,
                  .sections = labels.sections,
                  .pixel_size = labels.pixel_size};
  const std::size_t plane = pixels_in(labels.width, labels.height);
  if (plane == 0 || labels.ids.size() != plane * labels.sections)
    throw Error("empty-labels", "the labels have no pixels", "connect labels of a picture");
  for (int section = 0; section < labels.sections; ++section) {
    for (auto& [id, loops] : pixel_outlines(labels.ids.data() + plane * section, labels.width, labels.height))
      if (id <= labels.count())
        out.outlines.push_back({std::to_string(id), section, labels.classes[id - 1], 1, std::move(loops)});
  }
  return out;
}

OutlineFile outlines_of(const Profiles& profiles, int width, int height, double pixel_size) {
  OutlineFile out{.width = width, .height = height, .sections = profiles.sections, .pixel_size = pixel_size};
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    if (p.contour.empty())
      throw Error("no-outlines", fmt::format("profile {} has no outline", i),
                  "connect profiles of Segment, or labels");
    out.outlines.push_back(
        {std::to_string(i + 1), p.section, p.cls, p.confidence, {in_pixels(p.contour, pixel_size, height)}});
  }
  return out;
}

std::vector<std::vector<Loop>> polygons_of(const std::vector<Loop>& loops) {
  std::vector<std::vector<Loop>> out;
  for (const Loop& loop : loops)
    if (loops.size() == 1 || loop_area(loop) > 0) out.push_back({loop});
  for (const Loop& loop : loops) {
    if (loops.size() == 1 || loop_area(loop) > 0) continue;
    std::vector<Loop>* around = nullptr;
    for (auto& polygon : out)
      if (loop_contains(polygon[0], inside_of(loop)) &&
          (!around || loop_area(polygon[0]) < loop_area((*around)[0])))
        around = &polygon;
    if (around) around->push_back(loop);
  }
  return out;
}

}  // namespace terrazzo::exporting
