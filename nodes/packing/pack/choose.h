// Chooses how particles of a given density are packed.
#pragma once

#include <string>

#include "nodes/data/profiles.h"
#include "nodes/packing/rigid/packing.h"

namespace terrazzo::pack {

enum class Method { Auto, Anneal, Grow, Laguerre, Deposit };

struct Choice {
  Method method = Method::Anneal;  // not Auto
  packing::PackResult packed;      // with methods Anneal and Deposit
  bool joints = false;             // with method Laguerre: there is a binder between the cells
  std::string reason;              // a sentence
};

// Loose stones of a surface have fallen: Deposit. Stones of a surface in soil: Anneal, flat side down, as
// dense as they pack if less than requested. Of sections: without a binder (a volume fraction of 0.97 or
// more): Laguerre. Where the particles can be packed, or jam at a fraction that is less than requested by no
// more than its fraction_error() or 0.01: Anneal, and the packing, which continues from `start` (may be
// null). From a fraction of 0.75 on, if the `profiles` of the photograph (may be null) are equiaxed:
// Laguerre, since neighbors that leave each other so little room take each other's shape, and the binder is
// in joints between them. Otherwise: Grow. Of the options, only population and interrupted count. Throws the
// errors of pack_particles() except "jammed", and those of deposit_particles().
Choice choose_method(const SizeDistribution& distribution, const Shapes& shapes, const Profiles* profiles,
                     const Particles* start, const packing::PackOptions& options, const Work& work);

// With the box of a bed as wide as the surface in the photograph, unless edges are given.
packing::PopulationOptions bed_like(const SizeDistribution&, const Profiles&, packing::PopulationOptions);

// Standard error of the profiles' area fraction φ, if they lie at random: φ (1 − φ) √Σa² / Σa (Hilliard and
// Cahn 1961, times the share 1 − φ of each profile that covers what others leave free).
double fraction_error(const Profiles& profiles);

// The median ratio of the short to the long axis of the profiles that the border does not cut (of the
// ellipses with their second moments); 0 with fewer than five. Sections of Laguerre cells have about 0.75.
double usual_axis_ratio(const Profiles& profiles);

}  // namespace terrazzo::pack
