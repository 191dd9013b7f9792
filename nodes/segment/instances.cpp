#include "nodes/segment/instances.h"

#include <algorithm>
#include <numeric>

#include "nodes/segment/neighbors.h"

namespace terrazzo::segment {
namespace {
constexpr double kOverlap = 0.4;
}

Accepted accept_instances(std::vector<Instance> instances, int width, int height, double min_area,
                          double min_score, const Work& work) {
  std::vector<std::size_t> order(instances.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return instances[a].score > instances[b].score; });
  Accepted out;
  out.labels.assign(static_cast<std::size_t>(width) * height, 0);
  std::vector<std::int32_t> seen(out.labels.size(), -1);  // the instance whose pieces were traced last
  std::vector<std::int32_t> rest, piece, largest;
  for (const std::size_t k : order) {
    work.check();
    const Instance& in = instances[k];
    if (in.score < min_score || static_cast<double>(in.pixels.size()) < min_area) continue;
    rest.clear();
    for (const auto i : in.pixels)
      if (out.labels[i] == 0) rest.push_back(i), seen[i] = static_cast<std::int32_t>(k);
    const double free = static_cast<double>(rest.size());
    if (free < (1 - kOverlap) * static_cast<double>(in.pixels.size())) {
      for (const auto i : rest) seen[i] = -1;
      continue;
    }
    largest.clear();
    for (const auto first : rest) {
      if (seen[first] != static_cast<std::int32_t>(k)) continue;
      piece.assign(1, first);
      seen[first] = -1;
      for (std::size_t q = 0; q < piece.size(); ++q)
        neighbors(piece[q], width, height, [&](std::int32_t j) {
          if (seen[j] == static_cast<std::int32_t>(k)) seen[j] = -1, piece.push_back(j);
        });
      if (piece.size() > largest.size()) largest.swap(piece);
    }
    if (static_cast<double>(largest.size()) < min_area) continue;
    out.scores.push_back(in.score), out.from.push_back(k);
    for (const auto i : largest) out.labels[i] = static_cast<std::int32_t>(out.scores.size());
  }
  return out;
}

}  // namespace terrazzo::segment
