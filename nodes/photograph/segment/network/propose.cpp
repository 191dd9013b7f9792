#include "nodes/photograph/segment/network/propose.h"

namespace terrazzo::segment {

Proposal propose_by_network(NetworkSections& network, const Image& photo,
                            const NetworkProposalOptions& options, IgnoredPixels& ignored,
                            std::vector<FoundObject>& objects, const Work& work) {
  Proposal proposal;
  for (int i = 0; i < photo.sections; ++i) {
    const double sections = photo.sections;
    const auto view = network.view(i, work.part(i / sections, (i + 1) / sections));
    if (options.find_objects) add_objects_of_network(view->not_material(), i, photo, ignored, objects);
    NetworkView::Found chosen =
        view->choose(network.candidates(i, work.quiet()), options.choice, work.quiet());
    if (!options.fills_space) {
      const UndecidedPixels undecided = view->undecided(chosen.particles.labels);
      proposal.undecided.insert(proposal.undecided.end(), undecided.begin(), undecided.end());
    }
    proposal.add_chosen(std::move(chosen));
  }
  return proposal;
}

}  // namespace terrazzo::segment
