#include "nodes/photograph/segment/color/propose.h"

#include <algorithm>

#include "nodes/photograph/segment/color/faint_bodies.h"
#include "nodes/photograph/segment/color/shading.h"

namespace terrazzo::segment {
namespace {

// Separate phases differ strongly compared with the usual difference between neighboring patches.
constexpr double kDistinct = 5;

std::vector<Mosaic> mosaics_of(const Image& image, const Work& work) {
  std::vector<Mosaic> mosaics;
  const double sections = image.sections;
  for (int i = 0; i < image.sections; ++i)
    mosaics.push_back(make_mosaic(image, i, work.part(i / sections, (i + 1) / sections)));
  return mosaics;
}

void compare_phases(const std::vector<Mosaic>& mosaics, ColorProposal& out) {
  double apart = 0, usual = 0;
  for (const Mosaic& m : mosaics) {
    apart += m.spread;
    usual += m.contrast;
    out.distinct.push_back(m.spread >= kDistinct * m.contrast);
  }
  out.distinct_phases = apart >= kDistinct * usual;
}

}  // namespace

ColorProposal propose_by_color(const Image& image, const SegmentOptions& options, const Ground* known,
                               NetworkSections* judge, const Work& work) {
  ColorProposal out;
  std::vector<Mosaic> mosaics = mosaics_of(image, work.part(0, 0.85));
  compare_phases(mosaics, out);
  if (known) {
    out.ground = *known;
    even_light(mosaics, out.ground.clusters, work.quiet());
  } else {
    out.ground = find_ground(mosaics, options.clusters, options.binder, options.split.strength, options.seed,
                             work.part(0.85, 1));
  }
  for (int i = 0; i < image.sections; ++i) {
    Particles2D bodies = find_particles(mosaics[i], out.ground, options.split, work.quiet());
    const std::int32_t count = *std::max_element(bodies.labels.begin(), bodies.labels.end());
    if (!judge) {
      out.proposal.add(std::move(bodies), std::vector<double>(count, 1.0));
      continue;
    }
    std::vector<double> scores = judge->view(i, work.quiet())->scores(bodies.labels, count, work.quiet());
    out.proposal.add(bodies, confidences_of(scores));
    std::vector<bool> faint = faint_bodies(mosaics[i], bodies.labels, count);
    out.bodies.push_back({std::move(bodies), std::move(faint), std::move(scores)});
  }
  return out;
}

}  // namespace terrazzo::segment
