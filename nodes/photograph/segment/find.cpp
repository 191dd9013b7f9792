#include "nodes/photograph/segment/find.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "nodes/photograph/segment/attempt.h"
#include "nodes/photograph/segment/color/faint_bodies.h"
#include "nodes/photograph/segment/color/joined_bodies.h"
#include "nodes/photograph/segment/network/network_particles.h"
#include "nodes/photograph/segment/network/sharpness.h"

namespace terrazzo::segment {
namespace {

// What color separates in one section, and what the network says of it.
struct Bodies {
  Particles2D particles;
  std::vector<bool> faint;     // of label k at k − 1
  std::vector<double> scores;  // likewise
};

// The bodies that color separates and the instances of the network as rivals: the better score wins where
// they overlap. The colors of the phases must be distinct. Then color decides what is binder, and the
// outlines of bodies are finer, so their scores count more, and bodies without a rival stay even if the
// network does not know them, unless they are faint and it sees binder there at every scale. Instances of the
// network replace a body only if they cover most of it, since white specks in a pore are no reason to lose
// the pore, or if the rest of it is the gap between them.
NetworkView::Found choose_from_both(const NetworkView& view, std::vector<Instance> instances,
                                    const Bodies& by_color, const LabImage& image, const SplitOptions& split,
                                    const Work& work) {
  const int width = image.width, height = image.height;
  const Particles2D& bodies = by_color.particles;
  const std::vector<double>& scores = by_color.scores;
  constexpr double kBinder = 0.45;  // of `inside`
  const double lead = 1.6, least = NetworkOptions().min_score, first_of_all = 2;
  const double explained = 0.7, explained_of_joined = 0.3;
  std::vector<Instance> all;
  for (Instance& in : instances) {
    // Color decides what is binder.
    const auto on_bodies =
        std::count_if(in.pixels.begin(), in.pixels.end(), [&](auto i) { return bodies.labels[i] > 0; });
    if (2 * on_bodies >= static_cast<std::ptrdiff_t>(in.pixels.size())) all.push_back(std::move(in));
  }
  const std::size_t first = all.size();
  const std::int32_t count = *std::max_element(bodies.labels.begin(), bodies.labels.end());
  const std::vector<bool> joined = joined_bodies(image, bodies.labels, count, all, work);
  all.resize(first + count);
  for (std::size_t i = 0; i < bodies.labels.size(); ++i)
    if (const auto id = bodies.labels[i]; id > 0)
      all[first + id - 1].pixels.push_back(static_cast<std::int32_t>(i));
  for (std::int32_t k = 0; k < count; ++k)
    if (by_color.faint[k] && view.largest_inside(all[first + k].pixels) < kBinder)
      all[first + k].pixels.clear();
  for (std::int32_t k = 0; k < count; ++k) {
    all[first + k].score = std::max(least, lead * scores[k]);
    all[first + k].explained = joined[k] ? explained_of_joined : explained;
  }
  NetworkOptions how;
  how.min_area = split.min_area >= 0 ? split.min_area : std::min(how.min_area, bodies.min_area);
  NetworkView::Found found = view.choose(all, how, work);
  std::vector<std::int64_t> size(count + 1, 0), covered(count + 1, 0);
  for (std::size_t i = 0; i < bodies.labels.size(); ++i)
    ++size[bodies.labels[i]], covered[bodies.labels[i]] += found.particles.labels[i] > 0;
  bool lost = false;
  for (std::int32_t k = 0; k < count; ++k)
    if (!all[first + k].pixels.empty() && static_cast<double>(size[k + 1]) >= how.min_area &&
        static_cast<double>(covered[k + 1]) < all[first + k].explained * static_cast<double>(size[k + 1]))
      all[first + k].score = first_of_all, lost = true;
  if (lost) found = view.choose(all, how, work);
  const auto of_color = [&](std::int32_t label) { return label > 0 && found.from[label - 1] >= first; };
  for (std::size_t k = 0; k < found.from.size(); ++k)
    if (found.from[k] >= first) found.scores[k] = std::max(least / lead, scores[found.from[k] - first]);
  // Bodies keep their own outlines, on both sides.
  Particles2D& p = found.particles;
  for (std::size_t i = 0; i < p.labels.size(); ++i) {
    if (of_color(p.labels[i])) p.coverage[i] = std::max(0.5f, bodies.coverage[i]);
    if (p.labels[i] != 0 || bodies.labels[i] != 0) continue;
    const auto x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
        if (of_color(p.labels[static_cast<std::size_t>(v) * width + u]))
          p.coverage[i] = std::min(0.499f, bodies.coverage[i]);
  }
  return found;
}

// The photograph with cover_ignored() in all sections; empty if nothing is ignored.
Image without_ignored(const Image& photo, const IgnoredPixels& ignored) {
  if (ignored.empty()) return {};
  Image out = photo;
  for (int i = 0; i < photo.sections; ++i) cover_ignored(out, i, ignored);
  return out;
}

bool mostly_ignored(const Instance& in, const IgnoredPixels& ignored, std::size_t first) {
  if (ignored.empty()) return false;
  const auto n =
      std::count_if(in.pixels.begin(), in.pixels.end(), [&](auto i) { return ignored[first + i] != 0; });
  return 2 * n > static_cast<std::ptrdiff_t>(in.pixels.size());
}

}  // namespace

Finding find_in_whole(const Image& photo, const SegmentOptions& options, const Settled* settled,
                      const Work& work) {
  Finding found;
  Segmentation& s = found.result;
  IgnoredPixels& ignored = found.ignored;
  ignored = options.ignored;
  const int sections = photo.sections;
  s.method = options.method;
  if (s.method == Method::Auto && options.scribbles.particles && options.scribbles.binder)
    s.method = Method::Scribbles;
  const bool fills = options.binder.kind == Hint::Kind::None;
  if (s.method == Method::Auto && fills) s.method = Method::Network;
  // Who knows the binder or the number of clusters has chosen the method.
  if (s.method == Method::Auto && (options.binder.kind != Hint::Kind::Auto || options.clusters > 0))
    s.method = Method::Clusters;
  const bool network = s.method == Method::Auto || s.method == Method::Network;
  std::optional<Network> own;
  const Network* given = options.network;
  if (network && !given) given = &own.emplace(built_in_model());
  const Image covered = without_ignored(photo, ignored);
  const Image& seen = ignored.empty() ? photo : covered;  // by the network, which may find more to ignore
  if (network) s.network_scale = options.network_scale > 0 ? options.network_scale : network_scale_of(seen);
  // The maps of a stack can exceed its memory many times over, so those of large stacks are made again when
  // needed.
  const bool keep = photo.pixels.size() <= (16u << 20);
  std::vector<std::shared_ptr<const NetworkView>> views(sections);
  const auto view_of = [&](int i, const Work& part) {
    if (views[i]) return views[i];
    auto view = std::make_shared<const NetworkView>(seen, i, s.network_scale, *given, part);
    if (keep) views[i] = view;
    return std::shared_ptr<const NetworkView>(view);
  };
  NetworkOptions how;
  if (options.split.min_area >= 0)
    how.min_area = options.split.min_area;
  else if (network)
    how.min_area /= s.network_scale * s.network_scale;  // as the network sees it
  // Where colors are distinct, particles may be as small as bodies of color.
  constexpr double kSmallestBody = 12;
  NetworkOptions candidates = how;
  if (s.method == Method::Auto && options.split.min_area < 0)
    candidates.min_area = std::min(how.min_area, kSmallestBody);
  std::vector<std::vector<Instance>> instances(sections);  // kept for Auto like the views
  const auto find_instances = [&](int i, const NetworkView& view) {
    auto all = view.instances(candidates, work.quiet());
    std::erase_if(all, [&](const Instance& in) { return mostly_ignored(in, ignored, photo.index(0, 0, i)); });
    return all;
  };
  const auto instances_of = [&](int i) {
    return instances[i].empty() ? find_instances(i, *view_of(i, work.quiet())) : instances[i];
  };
  Attempt by_network;
  if (network)
    for (int i = 0; i < sections; ++i) {
      const auto view = view_of(i, work.part(0.4 * i / sections, 0.4 * (i + 1) / sections));
      // Without a binder the network takes plain grains for charts.
      if (options.find_objects && !fills)
        add_objects_of_network(view->not_material(), i, photo, ignored, s.not_material);
      auto all = find_instances(i, *view);
      NetworkView::Found chosen = view->choose(all, how, work.quiet());
      if (!fills) {
        const UndecidedPixels undecided = view->undecided(chosen.particles.labels);
        by_network.undecided.insert(by_network.undecided.end(), undecided.begin(), undecided.end());
      }
      by_network.add_chosen(std::move(chosen));
      if (keep && s.method == Method::Auto) instances[i] = std::move(all);
    }
  const Image covered_now = s.not_material.empty() ? Image() : without_ignored(photo, ignored);
  const Image& image = s.not_material.empty() ? seen : covered_now;

  std::vector<Bodies> by_color;  // of each section
  std::vector<bool> distinct;
  const auto by_clusters = [&] {
    std::vector<Mosaic> mosaics;
    for (int i = 0; i < sections; ++i)
      mosaics.push_back(
          make_mosaic(image, i, work.part(0.4 + 0.3 * i / sections, 0.4 + 0.3 * (i + 1) / sections)));
    // Separate phases differ strongly compared with the usual difference between neighboring patches.
    constexpr double kDistinct = 5;
    double apart = 0, usual = 0;
    for (const auto& m : mosaics) {
      apart += m.spread, usual += m.contrast;
      distinct.push_back(m.spread >= kDistinct * m.contrast);
    }
    s.distinct_phases = apart >= kDistinct * usual;
    if (settled && settled->ground) {
      s.ground = *settled->ground;
      even_light(mosaics, s.ground.clusters, work.quiet());
    } else {
      s.ground = find_ground(mosaics, options.clusters, options.binder, options.split.strength, options.seed,
                             work.part(0.7, 0.75));
    }
    Attempt a;
    for (int i = 0; i < sections; ++i) {
      Particles2D bodies = find_particles(mosaics[i], s.ground, options.split, work);
      const std::int32_t count = *std::max_element(bodies.labels.begin(), bodies.labels.end());
      if (!network) {
        a.add(std::move(bodies), std::vector<double>(count, 1.0));
        continue;
      }
      std::vector<double> scores = view_of(i, work.quiet())->scores(bodies.labels, count, work.quiet());
      a.add(bodies, confidences_of(scores));
      std::vector<bool> faint = faint_bodies(mosaics[i], bodies.labels, count);
      by_color.push_back({std::move(bodies), std::move(faint), std::move(scores)});
    }
    return a;
  };
  // Where colors are not distinct, their bodies only stand in the network's way.
  const auto by_both = [&] {
    Attempt a;
    for (int i = 0; i < sections; ++i) {
      const auto view = view_of(i, work.quiet());
      a.add_chosen(distinct[i]
                       ? choose_from_both(*view, instances_of(i), by_color[i],
                                          lab_section(image, i, work.quiet()), options.split, work.quiet())
                       : view->choose(instances_of(i), how, work.quiet()));
    }
    return a;
  };
  const auto by_scribbles = [&] {
    const ScribbleForest forest(image, 0, options.scribbles, options.seed, work.part(0, 0.2));
    Attempt a;
    for (int i = 0; i < sections; ++i) {
      const ScribbleMaps maps =
          forest.classify(image, i, work.part(0.2 + 0.6 * i / sections, 0.2 + 0.6 * (i + 1) / sections));
      Particles2D bodies =
          find_particles_by_scribbles(maps, image.width, image.height, options.split, work.quiet());
      const std::int32_t count = *std::max_element(bodies.labels.begin(), bodies.labels.end());
      if (options.scribbles.not_material) {
        ignored.resize(photo.pixels.size(), 0);
        for (std::size_t k = 0; k < maps.not_material.size(); ++k)
          if (maps.not_material[k] > 0.5f) ignored[photo.index(0, 0, i) + k] = 1;
      }
      // How clearly the trees agree: 0 where half of them say particle, 1 where all do.
      std::vector<double> sum(count, 0), pixels(count, 0);
      for (std::size_t k = 0; k < bodies.labels.size(); ++k)
        if (const auto id = bodies.labels[k]; id > 0)
          sum[id - 1] += std::max(0.0f, 2 * maps.particle[k] - 1), ++pixels[id - 1];
      for (std::int32_t k = 0; k < count; ++k) sum[k] /= std::max(1.0, pixels[k]);
      a.add(std::move(bodies), sum);
    }
    return a;
  };
  Attempt best;
  if (s.method == Method::Auto) {
    Attempt clusters = by_clusters();
    Attempt both = by_both();
    // The average precision to expect, right / (found + missed), if at least what the best of them gets right
    // is there.
    const Attempt::Weight c = clusters.weight(), n = by_network.weight(), t = both.weight();
    const double there = std::max({c.right, n.right, t.right});
    const auto precision = [&](const Attempt::Weight& w) {
      return w.right > 0 ? w.right / (w.found + there - w.right) : 0;
    };
    s.reliability = {precision(c), precision(n), precision(t)};
    // The network judges its own particles too, so it has to be a little better.
    constexpr double kLead = 1.1, kLeadOverBodies = 1.7;
    // Where much of what the network is sure of is binder by its color, color does not tell particles from
    // binder, as between fragments of many colors.
    constexpr double kForeign = 0.25;
    const bool joined = std::find(distinct.begin(), distinct.end(), true) != distinct.end() &&
                        by_network.left_out_by(both) <= kForeign;
    if (settled)
      s.method = settled->method;
    else if (!clusters.labels.classes.empty() &&
             kLead * s.reliability.clusters > std::max(s.reliability.both, s.reliability.network))
      s.method = Method::Clusters;
    else if (joined && kLeadOverBodies * s.reliability.both > s.reliability.network)
      s.method = Method::Both;
    else
      s.method = Method::Network;
    best = s.method == Method::Clusters ? std::move(clusters)
           : s.method == Method::Both   ? std::move(both)
                                        : std::move(by_network);
  } else {
    best = network ? std::move(by_network) : s.method == Method::Scribbles ? by_scribbles() : by_clusters();
  }
  for (int i = 0; i < sections; ++i) {
    if (fills)
      best.fill(i, image, network ? view_of(i, work.quiet()).get() : nullptr, work);
    else
      best.refine(i, image, work.quiet());
  }
  s.labels = std::move(best.labels);
  s.labels.width = image.width, s.labels.height = image.height, s.labels.sections = sections;
  s.labels.pixel_size = image.pixel_size;
  s.min_area = best.min_area, s.specks = best.specks, s.speck_pixels = best.speck_pixels,
  s.holes = best.holes;
  found.coverage = std::move(best.coverage), found.confidence = std::move(best.confidence);
  found.undecided = std::move(best.undecided);
  return found;
}

}  // namespace terrazzo::segment
