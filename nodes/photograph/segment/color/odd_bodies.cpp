#include "nodes/photograph/segment/color/odd_bodies.h"

#include <algorithm>
#include <limits>

#include "nodes/common/geometry/components.h"
#include "nodes/photograph/segment/color/pieces.h"

namespace terrazzo::segment {
namespace {

constexpr double kEdgeWidth = 6;  // pixels; a color change over a longer distance is not an edge

// Value with half of the weight at or below it.
float weighted_median(std::vector<std::pair<float, float>> values) {
  std::sort(values.begin(), values.end());
  double all = 0, sum = 0;
  for (const auto& v : values) all += v.second;
  for (const auto& v : values)
    if ((sum += v.second) >= all / 2) return v.first;
  return 0;
}

// Typical color of the binder in one of its clusters.
struct Usual {
  Vec3f color = Vec3f::Zero();
  float reach = 0;  // distance at which a color starts to stand out
};

std::vector<Usual> usual_binders(const Mosaic& m, const Ground& ground,
                                 const std::vector<bool>& is_particle) {
  std::vector<Usual> out;
  for (std::size_t c = 0; c < ground.is_binder.size(); ++c) {
    if (!ground.is_binder[c]) continue;
    std::vector<std::size_t> patches;
    for (std::size_t k = 0; k < m.colors.size(); ++k)
      if (!is_particle[k] && ground.clusters.nearest(m.colors[k]) == static_cast<int>(c))
        patches.push_back(k);
    if (patches.empty()) continue;
    Usual u;
    std::vector<std::pair<float, float>> values;
    for (int axis = 0; axis < 3; ++axis) {
      values.clear();
      for (const auto k : patches) values.emplace_back(m.colors[k][axis], m.areas[k]);
      u.color[axis] = weighted_median(values);
    }
    values.clear();
    for (const auto k : patches) values.emplace_back((m.colors[k] - u.color).norm(), m.areas[k]);
    u.reach = std::max({4 * weighted_median(values), 4 * m.contrast, 0.3f * m.spread});
    out.push_back(u);
  }
  return out;
}

struct Rim {
  double free = 0, beside_particles = 0;  // lengths in pixel edges
  double gradient = 0, difference = 0;    // sums along the free part
};

// Calls see(from, to) for neighbor pixels of different patches, in both directions.
template <class See>
void each_border(const Mosaic& m, See&& see) {
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::size_t i = m.index(x, y);
      if (x + 1 < m.width && m.patches[i] != m.patches[i + 1]) {
        see(i, i + 1);
        see(i + 1, i);
      }
      if (y + 1 < m.height && m.patches[i] != m.patches[i + m.width]) {
        see(i, i + m.width);
        see(i + m.width, i);
      }
    }
}

// A mottled body is close to the binder's color in places. So patches that stand out half as far join if
// more than half of their outline borders added patches.
void join_mottled(const Mosaic& m, const std::vector<float>& odd, std::vector<bool>& added) {
  const std::size_t n = odd.size();
  for (int round = 0; round < 3; ++round) {
    std::vector<double> outline(n, 0), along(n, 0);
    each_border(m, [&](std::size_t from, std::size_t to) {
      const std::int32_t a = m.patches[from] - 1, b = m.patches[to] - 1;
      outline[a] += 1;
      along[a] += added[b];
    });
    bool any = false;
    for (std::size_t k = 0; k < n; ++k)
      if (!added[k] && odd[k] > 0.5f && along[k] > 0.5 * outline[k]) added[k] = any = true;
    if (!any) break;
  }
}

}  // namespace

void add_odd_bodies(const Mosaic& m, const Ground& ground, double min_area, std::vector<bool>& is_particle,
                    const Work& work) {
  const std::vector<Usual> usual = usual_binders(m, ground, is_particle);
  if (usual.empty()) return;
  // How far each patch stands out, relative to the reach of the closest binder color.
  const std::size_t n = m.colors.size();
  std::vector<float> odd(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    if (is_particle[k]) continue;
    odd[k] = std::numeric_limits<float>::max();
    for (const Usual& u : usual) odd[k] = std::min(odd[k], (m.colors[k] - u.color).norm() / u.reach);
  }
  std::vector<std::int32_t> raster(m.patches.size());
  for (std::size_t i = 0; i < raster.size(); ++i) raster[i] = odd[m.patches[i] - 1] > 1;
  const Components bodies = connected_components(raster, m.width, m.height, false);
  work.check();
  const auto pieces = measure_pieces(bodies.ids, m.width, m.height);
  const auto gradient = gradient_of(m.smooth);
  std::vector<Rim> rims(pieces.size());
  each_border(m, [&](std::size_t from, std::size_t to) {
    if (bodies.ids[from] == 0 || bodies.ids[to] == bodies.ids[from]) return;
    Rim& r = rims[bodies.ids[from] - 1];
    const std::int32_t a = m.patches[from] - 1, b = m.patches[to] - 1;
    if (is_particle[b]) {
      r.beside_particles += 1;
      return;
    }
    r.free += 1;
    r.gradient += std::max(gradient[from], gradient[to]);
    r.difference += (m.colors[a] - m.colors[b]).norm();
  });
  std::vector<bool> added(n, false);
  for (std::size_t i = 0; i < raster.size(); ++i) {
    if (bodies.ids[i] == 0) continue;
    const Rim& r = rims[bodies.ids[i] - 1];
    const Piece& p = pieces[bodies.ids[i] - 1];
    if (p.area >= min_area && p.solidity() > 0.7 &&
        r.beside_particles <= 0.4 * (r.free + r.beside_particles) && r.gradient > r.difference / kEdgeWidth)
      added[m.patches[i] - 1] = true;
  }
  join_mottled(m, odd, added);
  for (std::size_t k = 0; k < n; ++k)
    if (added[k]) is_particle[k] = true;
}

}  // namespace terrazzo::segment
