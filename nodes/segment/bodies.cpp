#include "nodes/segment/bodies.h"

#include <algorithm>
#include <map>

#include "nodes/segment/pieces.h"
#include "nodes/segment/region_graph.h"
#include "nodes/segment/watershed.h"

namespace terrazzo {
namespace {

constexpr double depth =
    6;  // pixels: half the radius of the least round part that the full contrast sets apart

// Bodies that are no bodies of their own join the neighbour that they touch most. Returns whether any did.
bool join_slivers(std::vector<std::int32_t>& bodies, int width, int height, double min_area) {
  const auto pieces = measure_pieces(bodies, width, height);
  std::vector<std::map<std::int32_t, double>> contacts(pieces.size());
  auto touch = [&](std::int32_t a, std::int32_t b) {
    if (a != b && a != 0 && b != 0) contacts[a - 1][b] += 1, contacts[b - 1][a] += 1;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * width + x;
      if (x + 1 < width) touch(bodies[i], bodies[i + 1]);
      if (y + 1 < height) touch(bodies[i], bodies[i + width]);
    }
  std::vector<std::int32_t> target(pieces.size());
  bool any = false;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    target[k] = static_cast<std::int32_t>(k + 1);
    const Piece& p = pieces[k];
    std::int32_t most = 0;
    for (const auto& [other, length] : contacts[k])
      if (most == 0 || length > contacts[k][most]) most = other;
    if (most == 0 || pieces[most - 1].area < p.area) continue;
    const double embedded = contacts[k][most] / (p.outline + p.contact + p.at_border);
    if (p.area < 2 * min_area || p.area < 0.02 * pieces[most - 1].area || p.solidity() < 0.75 ||
        embedded > 0.6)
      target[k] = most, any = true;
  }
  for (auto& b : bodies)
    if (b != 0) b = target[b - 1];
  return any;
}

void renumber(std::vector<std::int32_t>& labels) {
  std::map<std::int32_t, std::int32_t> number;
  for (auto& l : labels)
    if (l != 0) l = number.emplace(l, static_cast<std::int32_t>(number.size()) + 1).first->second;
}

}  // namespace

std::vector<std::int32_t> color_bodies(const Mosaic& m, const std::vector<std::uint8_t>& particles,
                                       const std::vector<bool>& patch_is_particle, double min_area,
                                       const Work& work) {
  // Pixels that came to the particles when the outline was refined take the patch next to them.
  std::vector<std::int32_t> seeds(particles.size(), 0);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    if (particles[i] && patch_is_particle[m.patches[i] - 1]) seeds[i] = m.patches[i];
  auto labels = watershed(gradient_of(m.smooth), m.width, m.height, seeds, particles, work);
  // The binder, and particle pixels with no particle patch beside them, count as one more region that merges
  // with none.
  const std::int32_t outside = static_cast<std::int32_t>(m.colors.size()) + 1;
  for (auto& l : labels)
    if (l == 0) l = outside;
  RegionGraph graph(m.smooth, labels, std::vector<float>(labels.size(), 1.0f));
  graph.isolate(outside);
  graph.merge(depth * m.spread * m.spread, work);
  const auto merged = graph.labels();
  std::int32_t outside_now = 0;
  for (std::size_t i = 0; i < labels.size() && outside_now == 0; ++i)
    if (labels[i] == outside) outside_now = merged[i];
  std::vector<std::int32_t> bodies(labels.size(), 0);
  const std::int32_t rest = static_cast<std::int32_t>(m.colors.size()) + 2;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (particles[i]) bodies[i] = merged[i] == outside_now ? rest : merged[i];
  renumber(bodies);
  for (int round = 0; round < 4 && join_slivers(bodies, m.width, m.height, min_area); ++round)
    renumber(bodies);
  return bodies;
}

}  // namespace terrazzo
