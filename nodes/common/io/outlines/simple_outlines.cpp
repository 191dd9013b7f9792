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

// Coordinates along one axis: 0 for x, 1 for y.
struct LoopSide {
  Vec2 a, b;
  double low(int axis) const { return std::min(a[axis], b[axis]); }
  double high(int axis) const { return std::max(a[axis], b[axis]); }
  // The other coordinate, where the side passes `value`.
  double across(int axis, double value) const {
    return a[1 - axis] + (value - a[axis]) / (b[axis] - a[axis]) * (b[1 - axis] - a[1 - axis]);
  }
};

// Where two sides cross at a point inside of both.
std::optional<Vec2> crossing_of(const LoopSide& s, const LoopSide& t) {
  const Vec2 d = s.b - s.a, e = t.b - t.a;
  const double p = cross(d, t.a - s.a), q = cross(d, t.b - s.a), u = cross(e, s.a - t.a),
               v = cross(e, s.b - t.a);
  if (!((p < 0) != (q < 0) && p != 0 && q != 0 && (u < 0) != (v < 0) && u != 0 && v != 0)) return {};
  return s.a + d * (u / (u - v));
}

// The sides of loops by their lower ends along the axis in which the loops are longer.
struct SortedSides {
  int axis;
  Vec2 extent;
  std::vector<LoopSide> sides;
};
SortedSides sorted_sides(const std::vector<Loop>& loops) {
  SortedSides out;
  Vec2 low = Vec2::Constant(INFINITY), high = -low;
  for (const Loop& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      out.sides.push_back({loop[i], loop[(i + 1) % loop.size()]});
      low = low.cwiseMin(loop[i]);
      high = high.cwiseMax(loop[i]);
    }
  out.extent = high - low;
  out.axis = out.extent.x() < out.extent.y() ? 1 : 0;
  std::sort(out.sides.begin(), out.sides.end(),
            [axis = out.axis](const LoopSide& s, const LoopSide& t) { return s.low(axis) < t.low(axis); });
  return out;
}

// Only sides that overlap along the axis can cross.
std::optional<Vec2> crossing_in(const std::vector<Loop>& loops, const Work& work) {
  constexpr std::size_t kPairsBetweenChecks = 100'000;
  const auto [axis, extent, sides] = sorted_sides(loops);
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < sides.size(); ++i)
    for (std::size_t k = i + 1; k < sides.size() && sides[k].low(axis) < sides[i].high(axis); ++k) {
      if (++pairs % kPairsBetweenChecks == 0) work.check();
      if (const auto at = crossing_of(sides[i], sides[k])) return at;
    }
  return {};
}

// Whether a loop without such a crossing crosses itself at a corner. It then encloses parts twice or in the
// other direction, so that what lies inside an odd number of turns differs from its signed area. Both are
// sums over strips between the corners, in which no sides cross.
bool crosses_at_corner(const Loop& loop, const Work& work) {
  constexpr double kRounding = 1e-9;
  const auto [axis, extent, sides] = sorted_sides({loop});
  std::vector<double> ends;
  for (const Vec2& p : loop) ends.push_back(p[axis]);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<LoopSide> open;
  std::vector<double> at;
  std::size_t next = 0;
  double odd = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    if (i % 64 == 0) work.check();
    while (next < sides.size() && sides[next].low(axis) <= ends[i]) open.push_back(sides[next++]);
    std::erase_if(open, [&, axis = axis](const LoopSide& s) { return s.high(axis) <= ends[i]; });
    at.clear();
    for (const LoopSide& s : open) at.push_back(s.across(axis, (ends[i] + ends[i + 1]) / 2));
    std::sort(at.begin(), at.end());
    for (std::size_t k = 0; k + 1 < at.size(); k += 2) odd += (at[k + 1] - at[k]) * (ends[i + 1] - ends[i]);
  }
  return std::abs(odd - std::abs(loop_area(loop))) > kRounding * extent.squaredNorm();
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

void require_inside(const OutlineFile& all, const std::string& file) {
  constexpr double kOutside = 0.5, kLargest = 1e6;
  const bool known = all.width > 0;
  const Vec2 most = known ? Vec2(all.width + kOutside, all.height + kOutside) : Vec2(kLargest, kLargest);
  for (const FileOutline& o : all.outlines)
    for (const Loop& loop : o.loops)
      for (const Vec2& p : loop)
        if (!(p.x() >= -kOutside && p.y() >= -kOutside && p.x() <= most.x() && p.y() <= most.y()))
          throw bad_outline(file,
                            fmt::format("{} reaches ({:.6g}, {:.6g}), outside of the picture, which {}",
                                        o.name, p.x(), p.y(),
                                        known ? fmt::format("has {} × {} pixels", all.width, all.height)
                                              : "begins at (0, 0) and ends before (1000000, 1000000)"),
                            "use the outlines of this picture, in its pixels");
}

void require_simple(const OutlineFile& all, const std::string& file, const Work& work) {
  const char* hint = "repair the polygon in the program that made it";
  require_inside(all, file);
  for (const FileOutline& o : all.outlines) {
    work.check();
    double area = 0;
    for (const Loop& loop : o.loops) area += std::abs(loop_area(loop));
    if (const auto at = crossing_in(o.loops, work))
      throw bad_outline(file, fmt::format("{} crosses itself at ({:.6g}, {:.6g})", o.name, at->x(), at->y()),
                        hint);
    for (const Loop& loop : o.loops)
      if (crosses_at_corner(loop, work))
        throw bad_outline(file, o.name + " crosses itself at one of its corners", hint);
    if (!(area > 0))
      throw bad_outline(file, fmt::format("{} has no area", o.name), "remove it from the file");
  }
}

namespace {

// Pixels that two outlines share.
using SharedPixels = std::map<std::pair<std::int32_t, std::int32_t>, std::size_t>;

// Writes the number of outline k into its pixels of a section, and returns how many it has.
std::size_t draw_outline(const OutlineFile& all, std::size_t k, std::int32_t* section, SharedPixels& shared) {
  const auto number = static_cast<std::int32_t>(k) + 1;
  std::size_t pixels = 0;
  fill_loops(all.outlines[k].loops, all.width, all.height, [&](int y, int begin, int end) {
    pixels += end - begin;
    for (int x = begin; x < end; ++x) {
      std::int32_t& id = section[pixel_at(x, y, all.width)];
      if (id != 0) ++shared[{id, number}];
      id = number;
    }
  });
  return pixels;
}

void require_none(const SharedPixels& shared, const OutlineFile& all, const std::string& file) {
  if (shared.empty()) return;
  const auto& [pair, count] = *shared.begin();
  throw bad_outline(file,
                    fmt::format("{} and {} overlap by {} pixels ({} pairs of outlines overlap)",
                                all.outlines[pair.first - 1].name, all.outlines[pair.second - 1].name, count,
                                shared.size()),
                    "particles in a section cannot overlap: cut one of them");
}

}  // namespace

std::vector<std::int32_t> raster_of(const OutlineFile& all, const std::string& file, const Work& work) {
  const std::size_t plane = pixels_in(all.width, all.height);
  std::vector<std::int32_t> out(plane * all.sections, 0);
  SharedPixels shared;
  for (std::size_t k = 0; k < all.outlines.size(); ++k) {
    work.check();
    if (draw_outline(all, k, out.data() + plane * all.outlines[k].section, shared) == 0)
      throw bad_outline(file, fmt::format("{} contains the center of no pixel", all.outlines[k].name),
                        "remove it from the file, or use a picture with more pixels");
  }
  require_none(shared, all, file);
  return out;
}

void require_apart(const OutlineFile& all, const std::string& file, const Work& work) {
  std::map<int, std::vector<std::size_t>> sections;
  for (std::size_t k = 0; k < all.outlines.size(); ++k) sections[all.outlines[k].section].push_back(k);
  std::vector<std::int32_t> pixels(pixels_in(all.width, all.height));
  SharedPixels shared;
  for (const auto& [section, outlines] : sections) {
    std::fill(pixels.begin(), pixels.end(), 0);
    for (const std::size_t k : outlines) {
      work.check();
      draw_outline(all, k, pixels.data(), shared);
    }
  }
  require_none(shared, all, file);
}

std::map<std::int32_t, std::vector<Loop>> pixel_outlines(const std::int32_t* labels, int width, int height,
                                                         const Work& work) {
  std::map<std::int32_t, std::map<Corner, std::uint8_t>> edges;
  const auto label = [&](int x, int y) {
    return x < 0 || y < 0 || x >= width || y >= height ? 0 : labels[pixel_at(x, y, width)];
  };
  for (int y = 0; y < height; ++y) {
    work.check();
    for (int x = 0; x < width; ++x) {
      const std::int32_t id = label(x, y);
      if (id <= 0) continue;
      const auto differs = [&](int dx, int dy) { return label(x + dx, y + dy) != id; };
      if (differs(0, -1)) edges[id][{x, y}] |= 1;         // along the top, to the right
      if (differs(1, 0)) edges[id][{x + 1, y}] |= 2;      // down
      if (differs(0, 1)) edges[id][{x + 1, y + 1}] |= 4;  // to the left
      if (differs(-1, 0)) edges[id][{x, y + 1}] |= 8;     // up
    }
  }
  std::map<std::int32_t, std::vector<Loop>> out;
  for (auto& [id, own] : edges) {
    work.check();
    out[id] = join_edges(own);
  }
  return out;
}

}  // namespace terrazzo
