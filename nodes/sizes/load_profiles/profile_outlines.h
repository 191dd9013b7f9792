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
// Miles and Lantuéjoul. Throws Error "bad-outline" if two share pixels, "too-large".
Profiles profiles_of_outlines(const OutlineFile&, double pixel_size, const std::string& file, const Reading&);

}  // namespace terrazzo::load_profiles
