// Profiles from outlines of other programs.
#pragma once

#include <string>

#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/data/profiles.h"

namespace terrazzo::load_profiles {

// Whether JSON text holds outlines, not profiles that Export wrote.
bool is_outline_json(const std::string& text);

// Areas and centroids are those of the polygons without their holes, contours those of their largest parts.
// If the picture's size is known, profiles at its border have weight 0, and the others are weighted after
// Miles and Lantuéjoul. `picture`: null, or what they get their colors from. Throws Error "bad-outline" if
// two share pixels or parts and holes leave no area, "too-large".
Profiles profiles_of_outlines(OutlineFile, double pixel_size, const Image* picture, const std::string& file,
                              const Reading&, const Work& = {});

}  // namespace terrazzo::load_profiles
