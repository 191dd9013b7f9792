#include "nodes/media/annealing/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/common/texture/phase_statistics.h"
#include "nodes/data/indices.h"

namespace terrazzo::annealing {
namespace {
using media::cut;
using media::PhaseMap;

constexpr int kSlices = 12;        // per axis
constexpr int kTiles = 4;          // along each side of a picture
constexpr double kObserved = 0.9;  // least share of a tile
constexpr int kWhole = 2048;       // pixels along each side that are measured as one
constexpr int kMostReach = 64;     // pixels

// Side in pixels of the tiles that are compared.
int window_of(const PhaseMap& map, const Vec3i& size) {
  return std::min({map.width / 2, map.height / 2, size.minCoeff()});
}

double observed_share(const PhaseMap& map) {
  const auto unknown = std::count(map.at.begin(), map.at.end(), media::kUnobserved);
  return 1 - static_cast<double>(unknown) / static_cast<double>(map.at.size());
}

// Tiles of which little is observed say little; the best ones remain.
std::vector<PhaseMap> observed_tiles(std::vector<PhaseMap> tiles) {
  double best = 0;
  for (const PhaseMap& t : tiles) best = std::max(best, observed_share(t));
  std::erase_if(tiles, [&](const PhaseMap& t) { return observed_share(t) < std::min(kObserved, best); });
  return tiles;
}

// Evenly placed, from edge to edge; they overlap where they would not cover the picture otherwise.
std::vector<PhaseMap> tiles_of(const PhaseMap& map, int side) {
  std::vector<PhaseMap> out;
  const int across = std::min(kTiles, (map.width + side - 1) / side),
            down = std::min(kTiles, (map.height + side - 1) / side);
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i)
      out.push_back(cut(map, i * (map.width - side) / std::max(1, across - 1),
                        j * (map.height - side) / std::max(1, down - 1), side, side));
  return out;
}

PhaseMap slice_of(const Solid& solid, const PhaseMap& like, const Vec3i& size, int axis, int at) {
  const int columns = axis == 0 ? 1 : 0, rows = axis == 2 ? 1 : 2;
  PhaseMap out{size[columns], size[rows], like.phases, like.pixel_size, {}};
  for (int j = size[rows] - 1; j >= 0; --j)
    for (int i = 0; i < size[columns]; ++i) {
      Vec3i v;
      v[axis] = at;
      v[columns] = i;
      v[rows] = j;
      out.at.push_back(solid.phase[voxel_at(v.x(), v.y(), v.z(), size)]);
    }
  return out;
}

std::vector<PhaseMap> slices_of(const Solid& solid, const PhaseMap& like, const AnnealOptions& options,
                                int picture) {
  std::vector<PhaseMap> out;
  for (int axis = 0; axis < 3; ++axis) {
    if (options.plane[axis] != picture) continue;
    const int slices = std::min(kSlices, options.size[axis]);
    for (int k = 0; k < slices; ++k)
      out.push_back(slice_of(solid, like, options.size, axis, k * options.size[axis] / slices));
  }
  return out;
}

Phase phase_of(const PhaseMap& map, int phase) {
  Phase out{map.width, map.height, map.at};
  for (std::uint8_t& p : out.in) p = p == media::kUnobserved ? 2 : p == phase;
  return out;
}

struct Measures {
  std::vector<double> two_point, lineal_path, cluster;
  double fraction = 0, chord = 0, surface = 0, euler = 0, spanning = 0;
};

// Whether a piece reaches from one side of the window to the other: the mean of both directions.
double spanning(const Phase& p) {
  cv::Mat1b in(p.height, p.width);
  std::transform(p.in.begin(), p.in.end(), in.begin(), [](std::uint8_t v) { return v == 1; });
  cv::Mat1i pieces;
  const int count = cv::connectedComponents(in, pieces, 4);
  const auto meets = [&](const cv::Mat1i& a, const cv::Mat1i& b) {
    std::vector<std::uint8_t> seen(count, 0);
    for (const int piece : a) seen[piece] = 1;
    for (const int piece : b)
      if (piece > 0 && seen[piece]) return 1.0;
    return 0.0;
  };
  return (meets(pieces.col(0), pieces.col(p.width - 1)) + meets(pieces.row(0), pieces.row(p.height - 1))) / 2;
}

// Pieces less holes, with pixels connected by edges (Gray 1971); windows' edges cut as if all beyond were
// outside.
double euler_number(const Phase& p) {
  const auto in = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < p.width && y < p.height &&
           p.in[static_cast<std::size_t>(y) * p.width + x] == 1;
  };
  int quarters = 0;
  for (int y = 0; y <= p.height; ++y)
    for (int x = 0; x <= p.width; ++x) {
      const bool a = in(x - 1, y - 1), b = in(x, y - 1), c = in(x - 1, y), d = in(x, y);
      const int n = a + b + c + d;
      quarters += n == 1 ? 1 : n == 3 ? -1 : n == 2 && a == d ? 2 : 0;
    }
  return quarters / 4.0;
}

std::vector<Phase> phases_of(const std::vector<PhaseMap>& maps, int phase) {
  std::vector<Phase> out;
  for (const PhaseMap& m : maps) out.push_back(phase_of(m, phase));
  return out;
}

// What does not depend on the size of the windows.
void measure_lines(const std::vector<PhaseMap>& maps, int phase, int reach, Measures& out) {
  auto functions = phase_statistics(phases_of(maps, phase), reach);
  out.two_point = std::move(functions.two_point);
  out.lineal_path = std::move(functions.lineal_path);
  out.fraction = out.two_point[0];
  // Ends of chords per length of the lines.
  const double ends = 2 * (out.two_point[0] - out.two_point[1]) / maps[0].pixel_size;
  out.chord = ends > 0 ? 2 * out.fraction / ends : 0;
  out.surface = 2 * ends;
}

// What does.
void measure_windows(const std::vector<PhaseMap>& maps, int phase, int reach, Measures& out) {
  const auto phases = phases_of(maps, phase);
  const double pixel = maps[0].pixel_size;
  out.cluster = cluster_function(phases, reach);
  double area = 0, spanned = 0, pieces = 0;
  for (const Phase& p : phases) {
    pieces += euler_number(p);
    area += pixel * pixel * static_cast<double>(p.in.size() - std::count(p.in.begin(), p.in.end(), 2));
    spanned += spanning(p);
  }
  out.euler = pieces / area;
  out.spanning = spanned / phases.size();
}

Measures measure(const std::vector<PhaseMap>& maps, const std::vector<PhaseMap>& windows, int phase,
                 int reach) {
  Measures out;
  measure_lines(maps, phase, reach, out);
  measure_windows(windows, phase, reach, out);
  return out;
}

double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += std::abs(a[k] - b[k]);
  return sum / a.size();
}

template <class Get>
Agreement agreement(const char* name, const char* unit, const Measures& picture, const Measures& solid,
                    const std::vector<Measures>& tiles, Get&& get) {
  Agreement out;
  out.measure = name;
  out.unit = unit;
  out.of_picture = get(picture);
  out.of_solid = get(solid);
  out.low = out.high = get(tiles[0]);
  double squares = 0;
  for (const Measures& t : tiles) {
    const auto values = get(t);
    for (std::size_t k = 0; k < values.size(); ++k) {
      out.low[k] = std::min(out.low[k], values[k]);
      out.high[k] = std::max(out.high[k], values[k]);
    }
    const double d = mean_difference(values, out.of_picture);
    out.scatter += d / tiles.size();
    squares += d * d / tiles.size();
  }
  const bool number = out.of_picture.size() == 1;
  if (number) out.scatter = std::sqrt(squares);
  out.difference =
      number ? out.of_solid[0] - out.of_picture[0] : mean_difference(out.of_solid, out.of_picture);
  return out;
}

}  // namespace

std::vector<Agreement> compare_slices(const std::vector<PhaseMap>& pictures, const AnnealOptions& options,
                                      const Solid& solid, const Work& work) {
  std::vector<Agreement> out;
  for (std::size_t p = 0; p < pictures.size(); ++p) {
    const int side = window_of(pictures[p], options.size), reach = std::min(kMostReach, side / 2);
    const auto tiles = observed_tiles(tiles_of(pictures[p], side));
    const auto slices = slices_of(solid, pictures[p], options, p);
    std::vector<PhaseMap> windows;
    for (const PhaseMap& s : slices)
      for (PhaseMap& w : tiles_of(s, side)) windows.push_back(std::move(w));
    for (int phase = 0; phase < pictures[p].phases; ++phase) {
      work.check();
      const Measures of_picture = measure({middle_of(pictures[p], kWhole)}, tiles, phase, reach),
                     of_solid = measure(slices, windows, phase, reach);
      std::vector<Measures> parts;
      for (const PhaseMap& t : tiles) parts.push_back(measure({t}, {t}, phase, reach));
      const auto add = [&](const char* name, const char* unit, auto&& get) {
        out.push_back(agreement(name, unit, of_picture, of_solid, parts, get));
        out.back().picture = p;
        out.back().phase = phase;
      };
      const auto number = [](double Measures::*m) {
        return [m](const Measures& of) { return std::vector<double>{of.*m}; };
      };
      const auto function = [](std::vector<double> Measures::*m) {
        return [m](const Measures& of) { return of.*m; };
      };
      add("fraction", "", number(&Measures::fraction));
      add("two-point correlation", "", function(&Measures::two_point));
      add("lineal path", "", function(&Measures::lineal_path));
      add("cluster function", "", function(&Measures::cluster));
      add("mean chord", "mm", number(&Measures::chord));
      add("surface per volume", "1/mm", number(&Measures::surface));
      add("Euler number per area", "1/mm²", number(&Measures::euler));
      add("slices that it spans", "", number(&Measures::spanning));
    }
  }
  return out;
}

std::vector<Shown> show(const std::vector<PhaseMap>& pictures, const AnnealOptions& options,
                        const Solid& solid) {
  int side = options.size.minCoeff();
  for (const PhaseMap& p : pictures) side = std::min({side, p.width, p.height});
  std::vector<Shown> out;
  for (std::size_t p = 0; p < pictures.size(); ++p)
    out.push_back({pictures.size() > 1 ? fmt::format("picture {}", p + 1) : "picture",
                   cut(pictures[p], 0, 0, side, side)});
  for (int axis = 0; axis < 3; ++axis)
    out.push_back(
        {fmt::format("solid across {}", "xyz"[axis]),
         cut(slice_of(solid, pictures[0], options.size, axis, options.size[axis] / 2), 0, 0, side, side)});
  return out;
}

Table agreement_table(const std::vector<Agreement>& all) {
  Table t;
  t.columns = {"picture", "phase", "measure", "unit", "of picture", "of solid", "difference", "scatter"};
  for (const Agreement& a : all) {
    t.rows.push_back({static_cast<double>(a.picture + 1), static_cast<double>(a.phase), a.measure, a.unit,
                      std::string(), std::string(), a.difference, a.scatter});
    if (a.of_picture.size() != 1) continue;
    t.rows.back()[4] = a.of_picture[0];
    t.rows.back()[5] = a.of_solid[0];
  }
  return t;
}

}  // namespace terrazzo::annealing
