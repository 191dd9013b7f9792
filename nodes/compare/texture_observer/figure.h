// The crops that give the pictures away, and what they differ in.
#pragma once

#include "nodes/compare/texture_observer/observer.h"
#include "nodes/data/image.h"

namespace terrazzo::texture_observer {

// Shows the crops of which `shown` was most certain, rightly and wrongly, above bars of the accuracies of all
// observers and of their groups of features alone.
Image figure_of(const std::array<Verdict, 2>& verdicts, const Verdict& shown, const Halves& a,
                const Halves& b, const std::array<std::string, 2>& names);

}  // namespace terrazzo::texture_observer
