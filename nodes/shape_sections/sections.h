// Sections of single shapes as profiles, and a picture of them.
#pragma once

#include "nodes/common/random_sections.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"

namespace terrazzo::shape_sections {

// The three sections through the centroid across the principal axes of each body's volume, longest axis first
// (Jagnow et al. 2008, 4).
std::vector<BodySection> principal_sections(const Shapes&);

// A profile a disjoint outer outline, none cut by a border; holes are taken from its area. Sections follow
// each other on a grid, `pitch` mm apart, so that the profiles may be drawn as one picture.
Profiles profiles_of(const std::vector<BodySection>&, int columns, double pitch);

// The largest width or height of a section, mm.
double largest_extent(const std::vector<BodySection>&);

// Sections in rows of `columns`, each in a cell of `cell` pixels, black on white, antialiased, all at one
// scale of `pixels_per_mm`. Several row labels may be empty.
Image picture_of(const std::vector<BodySection>&, int columns, int cell, double pixels_per_mm,
                 const Work& = {});

}  // namespace terrazzo::shape_sections
