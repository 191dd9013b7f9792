#include "nodes/photograph/segment/find.h"

#include <algorithm>
#include <optional>

#include "nodes/photograph/segment/choose_method.h"
#include "nodes/photograph/segment/color/propose.h"
#include "nodes/photograph/segment/join_proposals.h"
#include "nodes/photograph/segment/network/propose.h"
#include "nodes/photograph/segment/network/sharpness.h"
#include "nodes/photograph/segment/proposal.h"
#include "nodes/photograph/segment/scribbles/propose.h"

namespace terrazzo::segment {
namespace {

// The photograph with cover_ignored() in all sections; none if nothing is ignored.
std::optional<Image> without_ignored(const Image& photo, const IgnoredPixels& ignored) {
  if (ignored.empty()) return {};
  Image out = photo;
  for (int i = 0; i < photo.sections; ++i) cover_ignored(out, i, ignored);
  return out;
}

// The least area of particles, in pixels of the photograph. The network's own least area is in the pixels
// that it sees.
NetworkOptions network_choice(const SegmentOptions& options, double scale) {
  NetworkOptions choice;
  choice.min_area = options.split.min_area >= 0 ? options.split.min_area : choice.min_area / (scale * scale);
  return choice;
}

// Where colors are distinct, particles may be as small as bodies of color.
NetworkOptions network_candidates(const SegmentOptions& options, Method method, NetworkOptions choice) {
  constexpr double kSmallestBody = 12;
  if (method == Method::Auto && options.split.min_area < 0)
    choice.min_area = std::min(choice.min_area, kSmallestBody);
  return choice;
}

// Takes the best of what color, the network and both together propose.
Proposal choose_best(ColorProposal by_color, Proposal by_network, Proposal both, const Settled* settled,
                     Segmentation& s) {
  s.reliability = reliability_of(by_color.proposal, by_network, both);
  s.method = settled ? settled->method : most_reliable(s.reliability, by_color, by_network);
  return s.method == Method::Clusters ? std::move(by_color.proposal)
         : s.method == Method::Both   ? std::move(both)
                                      : std::move(by_network);
}

void draw_outlines(Proposal& particles, const Image& image, bool fills_space, NetworkSections* network,
                   const Work& work) {
  for (int i = 0; i < image.sections; ++i) {
    if (fills_space)
      particles.fill(i, image, network ? network->view(i, work.quiet()).get() : nullptr, work);
    else
      particles.refine(i, image, work.quiet());
  }
}

void take(Proposal particles, const Image& image, Finding& found) {
  Segmentation& s = found.result;
  s.labels = std::move(particles.labels);
  s.labels.width = image.width;
  s.labels.height = image.height;
  s.labels.sections = image.sections;
  s.labels.pixel_size = image.pixel_size;
  s.min_area = particles.min_area;
  s.specks = particles.specks;
  s.speck_pixels = particles.speck_pixels;
  s.holes = particles.holes;
  found.coverage = std::move(particles.coverage);
  found.confidence = std::move(particles.confidence);
  found.undecided = std::move(particles.undecided);
}

}  // namespace

Finding find_in_whole(const Image& photo, const SegmentOptions& options, const Settled* settled,
                      const Work& work) {
  Finding found;
  Segmentation& s = found.result;
  s.method = method_of(options);
  found.ignored = options.ignored;
  const bool fills_space = options.binder.kind == Hint::Kind::None;
  const std::optional<Image> covered = without_ignored(photo, found.ignored);
  const Image& seen = covered ? *covered : photo;  // by the network, which may find more to ignore
  std::optional<Network> own;
  std::optional<NetworkSections> network;
  NetworkOptions choice;
  Proposal best, by_network;
  if (s.method == Method::Auto || s.method == Method::Network) {
    s.network_scale = options.network_scale > 0 ? options.network_scale : network_scale_of(seen);
    choice = network_choice(options, s.network_scale);
    const Network& trained = options.network ? *options.network : own.emplace(built_in_model());
    network.emplace(seen, s.network_scale, trained, network_candidates(options, s.method, choice),
                    found.ignored);
    // Without a binder the network takes plain grains for charts.
    by_network =
        propose_by_network(*network, photo, {choice, options.find_objects && !fills_space, fills_space},
                           found.ignored, s.not_material, work.part(0, 0.4));
  }
  const std::optional<Image> covered_again =
      s.not_material.empty() ? std::nullopt : without_ignored(photo, found.ignored);
  const Image& image = covered_again ? *covered_again : seen;
  if (s.method == Method::Auto || s.method == Method::Clusters) {
    ColorProposal by_color = propose_by_color(image, options, settled ? settled->ground : nullptr,
                                              network ? &*network : nullptr, work.part(0.4, 0.75));
    s.ground = std::move(by_color.ground);
    s.distinct_phases = by_color.distinct_phases;
    if (s.method == Method::Auto) {
      Proposal both = join_proposals(image, by_color, *network, choice, options.split, work.quiet());
      best = choose_best(std::move(by_color), std::move(by_network), std::move(both), settled, s);
    } else {
      best = std::move(by_color.proposal);
    }
  } else if (s.method == Method::Network) {
    best = std::move(by_network);
  } else {
    best = propose_by_scribbles(image, options, found.ignored, work.part(0, 0.8));
  }
  draw_outlines(best, image, fills_space, network ? &*network : nullptr, work);
  take(std::move(best), image, found);
  return found;
}

}  // namespace terrazzo::segment
