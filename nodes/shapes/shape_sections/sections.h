// Sections of single shapes as profiles, and an image of them.
#pragma once

#include "nodes/common/stereology/random_sections.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"

namespace terrazzo::shape_sections {

// The three sections through the centroid perpendicular to the principal axes of each body's volume, that
// across the longest axis first (Jagnow et al. 2008, section 4).
std::vector<BodySection> principal_sections(const Shapes&);

// One profile per disjoint outer outline, none cut by a border; areas exclude holes. Sections are arranged on
// a grid with spacing `pitch` mm, so that the profiles may be drawn as one image.
Profiles profiles_of(const std::vector<BodySection>&, int columns, double pitch);

// The largest width or height of a section, mm.
double largest_extent(const std::vector<BodySection>&);

// Sections in rows of `columns`, each in a cell of `cell` pixels, black on white, antialiased, all
// at the scale `pixels_per_mm`.
Image picture_of(const std::vector<BodySection>&, int columns, int cell, double pixels_per_mm,
                 const Work& = {});

}  // namespace terrazzo::shape_sections
