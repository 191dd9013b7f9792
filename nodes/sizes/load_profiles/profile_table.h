// Tables of measured profiles, as written by ImageJ, GrainSizeTools and spreadsheets.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "nodes/data/profiles.h"

namespace terrazzo::load_profiles {

// Factors from a file's numbers to mm and mm².
struct ProfileUnit {
  std::string name;   // as the user wrote it
  double length = 1;  // mm per unit of a diameter or position
  double area = 1;    // mm² per unit of an area
};

// Accepts "mm", "µm", "um", "nm", "cm", "m" and their squares ("µm²", "um2"); nothing for "auto". Throws
// Error "unknown-unit".
std::optional<ProfileUnit> profile_unit(const std::string& name);

// Reads a table whose cells are separated by tabs, semicolons, commas or blanks (CellReader). Columns are
// found by name; case, units and text in brackets are ignored. Required is `area`, else `diameter` (also
// `ecd`, `equivalent diameter`; area = π d²/4). Optional are `section` or `slice`, `class`, `weight`,
// `confidence`, `touches_border`, `centroid_x`, `centroid_y`, `color_r`, `color_g`, `color_b`, `view` (the
// same in all rows) and `whole`. A table of one column without a header contains areas. Empty lines and lines
// that begin with # are skipped.
//
// Numbers are in the unit that the header of their column names, else in `unit`, else in that of the other
// columns of lengths and areas, such as ImageJ's "Perim. (mm)", else in mm, with a warning. Rows of
// statistics below a table ("Mean", "SD", "Min", "Max") are left out, with a warning.
//
// `file` is used in messages only. Throws Error "malformed-row" with file:line, "no-column", "no-particles",
// "unknown-unit", "contradicting-unit".
Profiles read_profiles(
    const std::string& text, const std::string& file, const std::optional<ProfileUnit>& unit,
    const std::function<void(const std::string&)>& warn = [](const std::string&) {});

}  // namespace terrazzo::load_profiles
