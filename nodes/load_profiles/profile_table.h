// Tables of measured profiles, as written by ImageJ, GrainSizeTools and spreadsheets.
#pragma once

#include <string>

#include "nodes/data/profiles.h"

namespace terrazzo::load_profiles {

// Factors from a file's numbers to mm and mm².
struct ProfileUnit {
  double length = 1;  // mm per unit of a diameter or position
  double area = 1;    // mm² per unit of an area
};

// Accepts "mm", "µm", "um", "nm", "cm", "m" and their squares ("µm²", "um2"). Throws Error "unknown-unit".
ProfileUnit profile_unit(const std::string& name);

// Reads a table whose cells are separated by tabs, semicolons, commas or blanks, as detected in the first
// line. Columns are found by name; case and text in brackets are ignored. Required is `area`, else `diameter`
// (also `ecd`, `equivalent diameter`; area = π d²/4). Optional are `section` or `slice`, `class`, `weight`,
// `confidence`, `touches_border`, `centroid_x`, `centroid_y`, `color_r`, `color_g`, `color_b`. A table of one
// column without a header contains areas. Empty lines and lines that begin with # are skipped. `file` is used
// in messages only. Throws Error "malformed-row" with file:line, "no-column", "no-particles".
Profiles read_profiles(const std::string& text, const std::string& file, const ProfileUnit& unit);

}  // namespace terrazzo::load_profiles
