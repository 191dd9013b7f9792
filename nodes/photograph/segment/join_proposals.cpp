#include "nodes/photograph/segment/join_proposals.h"

#include <algorithm>

#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

constexpr double kLead = 1.6;       // factor of the scores of bodies, since color draws finer outlines
constexpr double kFirst = 2;        // score of bodies that must not be lost
constexpr double kBinder = 0.45;    // of the network's `inside`: below it, the network sees binder
constexpr double kSure = 0.6;       // score from which the network may contradict color
constexpr double kExplained = 0.3;  // share of a body that candidates must cover to replace it

// Candidates of which at least half lies on bodies: color decides what is binder, unless the network is sure.
// The faintest particles have no patch of their own, and in uneven light some have the binder's color.
std::vector<Instance> on_bodies(std::vector<Instance> candidates, const Particles2D& bodies) {
  std::erase_if(candidates, [&](const Instance& in) {
    if (in.score >= kSure) return false;
    const auto on =
        std::count_if(in.pixels.begin(), in.pixels.end(), [&](auto i) { return bodies.labels[i] > 0; });
    return 2 * on < static_cast<std::ptrdiff_t>(in.pixels.size());
  });
  return candidates;
}

// Bodies as rivals of candidates. A body that the network does not know stays, unless it is faint and the
// network sees binder there at every scale.
std::vector<Instance> rivals_of(const Bodies& by_color, const NetworkView& view) {
  std::vector<Instance> rivals(by_color.scores.size());
  const auto& labels = by_color.particles.labels;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] > 0) rivals[labels[i] - 1].pixels.push_back(static_cast<std::int32_t>(i));
  for (std::size_t k = 0; k < rivals.size(); ++k) {
    if (by_color.faint[k] && view.largest_inside(rivals[k].pixels) < kBinder) rivals[k].pixels.clear();
    rivals[k].score = std::max(NetworkOptions().min_score, kLead * by_color.scores[k]);
    rivals[k].explained = kExplained;
  }
  return rivals;
}

// Raises the scores of bodies that `found` replaces without covering enough of them: white specks in a pore
// are no reason to lose the pore. Returns whether there are any. Bodies are the instances from `first` on.
bool keep_lost_bodies(const NetworkView::Found& found, const std::vector<std::int32_t>& bodies,
                      std::size_t first, double min_area, std::vector<Instance>& all) {
  const std::size_t count = all.size() - first;
  std::vector<std::int64_t> size(count + 1, 0), covered(count + 1, 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    ++size[bodies[i]];
    covered[bodies[i]] += found.particles.labels[i] > 0;
  }
  bool lost = false;
  for (std::size_t k = 0; k < count; ++k) {
    Instance& body = all[first + k];
    if (body.pixels.empty() || size[k + 1] < min_area || covered[k + 1] >= body.explained * size[k + 1])
      continue;
    body.score = kFirst;
    lost = true;
  }
  return lost;
}

// Gives particles that are bodies their outlines by color, on both sides.
void keep_outlines(Particles2D& p, const Particles2D& bodies, int width, int height,
                   const std::vector<std::size_t>& from, std::size_t first) {
  const auto of_color = [&](std::int32_t label) { return label > 0 && from[label - 1] >= first; };
  for (std::size_t i = 0; i < p.labels.size(); ++i) {
    if (of_color(p.labels[i])) p.coverage[i] = std::max(0.5f, bodies.coverage[i]);
    if (p.labels[i] != 0 || bodies.labels[i] != 0) continue;
    const int x = i % width, y = i / width;
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
        if (of_color(p.labels[pixel_at(u, v, width)])) p.coverage[i] = std::min(0.499f, bodies.coverage[i]);
  }
}

NetworkView::Found choose_among_rivals(const NetworkView& view, std::vector<Instance> candidates,
                                       const Bodies& by_color, const Image& image, const SplitOptions& split,
                                       const Work& work) {
  const Particles2D& bodies = by_color.particles;
  std::vector<Instance> all = on_bodies(std::move(candidates), bodies);
  const std::size_t first = all.size();
  for (Instance& body : rivals_of(by_color, view)) all.push_back(std::move(body));
  NetworkOptions options;
  options.min_area = split.min_area >= 0 ? split.min_area : std::min(options.min_area, bodies.min_area);
  NetworkView::Found found = view.choose(all, options, work);
  if (keep_lost_bodies(found, bodies.labels, first, options.min_area, all))
    found = view.choose(all, options, work);
  for (std::size_t k = 0; k < found.from.size(); ++k)
    if (found.from[k] >= first)
      found.scores[k] = std::max(options.min_score / kLead, by_color.scores[found.from[k] - first]);
  keep_outlines(found.particles, bodies, image.width, image.height, found.from, first);
  return found;
}

}  // namespace

Proposal join_proposals(const Image& image, const ColorProposal& by_color, NetworkSections& network,
                        const NetworkOptions& choice, const SplitOptions& split, const Work& work) {
  Proposal joined;
  for (int i = 0; i < image.sections; ++i) {
    const auto view = network.view(i, work.quiet());
    std::vector<Instance> candidates = network.candidates(i, work.quiet());
    joined.add_chosen(by_color.distinct[i]
                          ? choose_among_rivals(*view, std::move(candidates), by_color.bodies[i], image,
                                                split, work.quiet())
                          : view->choose(candidates, choice, work.quiet()));
  }
  return joined;
}

}  // namespace terrazzo::segment
