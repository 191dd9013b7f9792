#include "nodes/photograph/segment/color/bodies.h"

#include <algorithm>
#include <map>

#include "nodes/common/geometry/components.h"
#include "nodes/photograph/segment/color/pieces.h"
#include "nodes/photograph/segment/color/region_graph.h"
#include "nodes/photograph/segment/color/watershed.h"

namespace terrazzo::segment {
namespace {

// Pixels: half the radius of the smallest disk that stays separate at a contrast of one spread.
constexpr double kDepth = 6;

struct Contact {
  double length = 0, gradient = 0;
};

// Joins dubious bodies to the neighbor with the longest contact: slivers, bodies mostly enclosed by the
// neighbor, and bodies without an edge towards it (where the color changes over more than six pixels).
// Returns whether any joined.
bool join_slivers(std::vector<std::int32_t>& bodies, const Mosaic& m, const std::vector<float>& gradient,
                  double min_area) {
  const auto pieces = measure_pieces(bodies, m.width, m.height);
  std::vector<Eigen::Vector3d> colors(pieces.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i] != 0)
      colors[bodies[i] - 1] += m.smooth.pixels[i].cast<double>() / pieces[bodies[i] - 1].area;
  std::vector<std::map<std::int32_t, Contact>> contacts(pieces.size());
  auto touch = [&](std::size_t i, std::size_t j) {
    const std::int32_t a = bodies[i], b = bodies[j];
    if (a == b || a == 0 || b == 0) return;
    const double g = std::max(gradient[i], gradient[j]);
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
      Contact& c = contacts[from - 1][to];
      c.length += 1;
      c.gradient += g;
    }
  };
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::size_t i = m.index(x, y);
      if (x + 1 < m.width) touch(i, i + 1);
      if (y + 1 < m.height) touch(i, i + m.width);
    }
  std::vector<std::int32_t> target(pieces.size());
  bool any = false;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    target[k] = k + 1;
    const Piece& p = pieces[k];
    std::int32_t most = 0;
    Contact contact;
    for (const auto& [other, c] : contacts[k])
      if (most == 0 || c.length > contact.length) {
        most = other;
        contact = c;
      }
    if (most == 0 || pieces[most - 1].area < p.area) continue;
    const double embedded = contact.length / (p.outline + p.contact + p.at_border);
    const double difference = (colors[k] - colors[most - 1]).norm();
    const bool no_edge = contact.gradient / contact.length < difference / 6;
    if (p.area < 2 * min_area || p.area < 0.02 * pieces[most - 1].area || p.solidity() < 0.75 ||
        embedded > 0.6 || no_edge) {
      target[k] = most;
      any = true;
    }
  }
  for (auto& b : bodies)
    if (b != 0) b = target[b - 1];
  return any;
}

}  // namespace

std::vector<std::int32_t> color_bodies(const Mosaic& m, const std::vector<std::uint8_t>& particles,
                                       const std::vector<bool>& patch_is_particle, double min_area,
                                       const Work& work) {
  // Pixels that refine_outline added to the particles get the patch of their neighbors.
  std::vector<std::int32_t> seeds(particles.size(), 0);
  for (std::size_t i = 0; i < seeds.size(); ++i)
    if (particles[i] && patch_is_particle[m.patches[i] - 1]) seeds[i] = m.patches[i];
  const std::vector<float> gradient = gradient_of(m.smooth);
  auto labels = watershed(gradient, m.width, m.height, seeds, particles, work);
  // The binder, and particle pixels that touch no particle patch, form one more region that never merges.
  const std::int32_t outside = static_cast<std::int32_t>(m.colors.size()) + 1;
  bool any_outside = false;
  for (auto& l : labels)
    if (l == 0) {
      l = outside;
      any_outside = true;
    }
  RegionGraph graph(m.smooth, labels, std::vector<float>(labels.size(), 1.0f));
  if (any_outside) graph.isolate(outside);
  graph.merge(kDepth * m.spread * m.spread, work);
  const auto merged = graph.labels();
  std::int32_t outside_now = 0;
  for (std::size_t i = 0; any_outside && i < labels.size() && outside_now == 0; ++i)
    if (labels[i] == outside) outside_now = merged[i];
  std::vector<std::int32_t> bodies(labels.size(), 0);
  const std::int32_t rest = static_cast<std::int32_t>(m.colors.size()) + 2;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (particles[i]) bodies[i] = merged[i] == outside_now ? rest : merged[i];
  renumber_labels(bodies);
  for (int round = 0; round < 4 && join_slivers(bodies, m, gradient, min_area); ++round)
    renumber_labels(bodies);
  return bodies;
}

}  // namespace terrazzo::segment
