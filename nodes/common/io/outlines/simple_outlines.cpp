// Checks of outlines, their pixels, and the outlines of pixels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "nodes/common/geometry/fill_loops.h"
#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

struct LoopSide {
  Vec2 a, b;
  double left() const { return std::min(a.x(), b.x()); }
  double right() const { return std::max(a.x(), b.x()); }
};

// Where two sides cross at a point inside of both.
std::optional<Vec2> crossing_of(const LoopSide& s, const LoopSide& t) {
  const Vec2 d = s.b - s.a, e = t.b - t.a;
  const double p = cross(d, t.a - s.a), q = cross(d, t.b - s.a), u = cross(e, s.a - t.a),
               v = cross(e, s.b - t.a);
  if (!((p < 0) != (q < 0) && p != 0 && q != 0 && (u < 0) != (v < 0) && u != 0 && v != 0)) return {};
  return s.a + d * (u / (u - v));
}

// Of sides sorted by their left ends, only those that overlap in x can cross.
std::optional<Vec2> crossing_in(const std::vector<Loop>& loops) {
  std::vector<LoopSide> sides;
  for (const Loop& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) sides.push_back({loop[i], loop[(i + 1) % loop.size()]});
  std::sort(sides.begin(), sides.end(),
            [](const LoopSide& s, const LoopSide& t) { return s.left() < t.left(); });
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t k = i + 1; k < sides.size() && sides[k].left() < sides[i].right(); ++k)
      if (const auto at = crossing_of(sides[i], sides[k])) return at;
  return {};
}

// A corner of pixels from which an edge of a label starts.
struct Corner {
  int x, y;
  bool operator<(const Corner& o) const { return y < o.y || (y == o.y && x < o.x); }
};
constexpr int kStepX[] = {1, 0, -1, 0}, kStepY[] = {0, 1, 0, -1};  // right, down, left, up

// Without the points that lie on a straight line.
Loop corners_of(const std::vector<Corner>& walk) {
  Loop out;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    const Corner &before = walk[(i + walk.size() - 1) % walk.size()], &after = walk[(i + 1) % walk.size()];
    if (before.x != after.x && before.y != after.y) out.emplace_back(walk[i].x, walk[i].y);
  }
  return out;
}

// Joins the edges of one label to loops. A walk that comes back to a corner closes a loop there, so that
// loops only touch.
std::vector<Loop> join_edges(std::map<Corner, std::uint8_t>& edges) {
  std::vector<Loop> out;
  while (!edges.empty()) {
    std::vector<Corner> walk;
    std::map<Corner, std::size_t> place;  // in the walk
    Corner at = edges.begin()->first;
    int direction = 0;
    do {
      place[at] = walk.size();
      walk.push_back(at);
      const auto edge = edges.find(at);
      // The label lies to the right. A turn to the right keeps pixels apart that only touch at a corner.
      int turn = 1;
      while (!(edge->second >> (direction + turn) % 4 & 1)) turn = (turn + 3) % 4;
      direction = (direction + turn) % 4;
      edge->second &= ~(1 << direction);
      if (edge->second == 0) edges.erase(edge);
      at = {at.x + kStepX[direction], at.y + kStepY[direction]};
      const auto before = place.find(at);
      if (before == place.end()) continue;
      const auto first = walk.begin() + static_cast<std::ptrdiff_t>(before->second);
      out.push_back(corners_of({first, walk.end()}));
      for (auto corner = first; corner != walk.end(); ++corner) place.erase(*corner);
      walk.erase(first, walk.end());
    } while (!walk.empty());
  }
  return out;
}

}  // namespace

void require_simple(const OutlineFile& all, const std::string& file) {
  constexpr double kOutside = 0.5;
  for (const FileOutline& o : all.outlines) {
    if (all.width > 0)
      for (const Loop& loop : o.loops)
        for (const Vec2& p : loop)
          if (!(p.x() >= -kOutside && p.y() >= -kOutside && p.x() <= all.width + kOutside &&
                p.y() <= all.height + kOutside))
            throw bad_outline(
                file,
                fmt::format("{} reaches ({:.6g}, {:.6g}), outside of the picture of {} × {} pixels", o.name,
                            p.x(), p.y(), all.width, all.height),
                "use the outlines of this picture, in its pixels");
    double area = 0;
    for (const Loop& loop : o.loops) area += std::abs(loop_area(loop));
    if (!(area > 0))
      throw bad_outline(file, fmt::format("{} has no area", o.name), "remove it from the file");
    if (const auto at = crossing_in(o.loops))
      throw bad_outline(file, fmt::format("{} crosses itself at ({:.6g}, {:.6g})", o.name, at->x(), at->y()),
                        "repair the polygon in the program that made it");
  }
}

std::vector<std::int32_t> raster_of(const OutlineFile& all, const std::string& file) {
  const std::size_t plane = pixels_in(all.width, all.height);
  std::vector<std::int32_t> out(plane * all.sections, 0);
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> shared;
  for (std::size_t k = 0; k < all.outlines.size(); ++k) {
    const FileOutline& o = all.outlines[k];
    std::size_t pixels = 0;
    fill_loops(o.loops, all.width, all.height, [&](int y, int begin, int end) {
      pixels += end - begin;
      for (int x = begin; x < end; ++x) {
        std::int32_t& id = out[plane * o.section + pixel_at(x, y, all.width)];
        if (id != 0) ++shared[{id, static_cast<std::int32_t>(k) + 1}];
        id = static_cast<std::int32_t>(k) + 1;
      }
    });
    if (pixels == 0)
      throw bad_outline(file, fmt::format("{} contains the center of no pixel", o.name),
                        "remove it from the file, or use a picture with more pixels");
  }
  if (!shared.empty()) {
    const auto& [pair, count] = *shared.begin();
    throw bad_outline(file,
                      fmt::format("{} and {} overlap by {} pixels ({} pairs of outlines overlap)",
                                  all.outlines[pair.first - 1].name, all.outlines[pair.second - 1].name,
                                  count, shared.size()),
                      "particles in a section cannot overlap: cut one of them");
  }
  return out;
}

std::vector<std::vector<Loop>> pixel_outlines(const std::int32_t* labels, int width, int height, int count) {
  std::vector<std::map<Corner, std::uint8_t>> edges(count);
  const auto label = [&](int x, int y) {
    return x < 0 || y < 0 || x >= width || y >= height ? 0 : labels[pixel_at(x, y, width)];
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::int32_t id = label(x, y);
      if (id <= 0 || id > count) continue;
      auto& own = edges[id - 1];
      if (label(x, y - 1) != id) own[{x, y}] |= 1;          // along the top, to the right
      if (label(x + 1, y) != id) own[{x + 1, y}] |= 2;      // down
      if (label(x, y + 1) != id) own[{x + 1, y + 1}] |= 4;  // to the left
      if (label(x - 1, y) != id) own[{x, y + 1}] |= 8;      // up
    }
  std::vector<std::vector<Loop>> out;
  for (auto& own : edges) out.push_back(join_edges(own));
  return out;
}

}  // namespace terrazzo
