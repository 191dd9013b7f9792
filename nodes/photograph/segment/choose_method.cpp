#include "nodes/photograph/segment/choose_method.h"

#include <algorithm>

namespace terrazzo::segment {

Method method_of(const SegmentOptions& options) {
  if (options.method != Method::Auto) return options.method;
  if (options.scribbles.particles && options.scribbles.binder) return Method::Scribbles;
  if (options.binder.kind == Hint::Kind::None) return Method::Network;
  if (options.binder.kind != Hint::Kind::Auto || options.clusters > 0) return Method::Clusters;
  return Method::Auto;
}

Reliability reliability_of(const Proposal& clusters, const Proposal& network, const Proposal& both) {
  const Proposal::Weight c = clusters.weight();
  const Proposal::Weight n = network.weight();
  const Proposal::Weight b = both.weight();
  const double there = std::max({c.right, n.right, b.right});
  const auto precision = [&](const Proposal::Weight& w) {
    return w.right > 0 ? w.right / (w.found + there - w.right) : 0;
  };
  return {precision(c), precision(n), precision(b)};
}

Method most_reliable(const Reliability& r, const ColorProposal& by_color, const Proposal& network) {
  constexpr double kLeadOverClusters = 1.1, kLeadOverBoth = 1.7;
  // Where much of what the network is sure of is binder by its color, color does not tell particles from
  // binder, as between fragments of many colors.
  constexpr double kForeign = 0.25;
  const bool any_distinct = std::count(by_color.distinct.begin(), by_color.distinct.end(), true) > 0;
  if (!by_color.proposal.labels.classes.empty() &&
      kLeadOverClusters * r.clusters > std::max(r.both, r.network))
    return Method::Clusters;
  if (any_distinct && network.left_out_by(by_color.proposal) <= kForeign &&
      kLeadOverBoth * r.both > r.network)
    return Method::Both;
  return Method::Network;
}

}  // namespace terrazzo::segment
