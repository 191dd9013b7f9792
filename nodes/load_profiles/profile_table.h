// Tables of measured sections as ImageJ, GrainSizeTools and spreadsheets write them.
#pragma once

#include <string>

#include "nodes/data/profiles.h"

namespace terrazzo {

// How a file's numbers become mm and mm².
struct ProfileUnit {
  double length = 1;  // mm per unit of a diameter or position
  double area = 1;    // mm² per unit of an area
};

// "mm", "µm", "um", "nm", "cm", "m", or the same squared ("µm²", "um2"). Throws Error "unknown-unit".
ProfileUnit profile_unit(const std::string& name);

// Reads the text of a table whose cells are parted by tabs, semicolons, commas or blanks, whichever the first
// line shows. Columns by name, whatever their case and words in brackets: `area`, else `diameter` (also
// `ecd`, `equivalent diameter`; area = π d²/4); and where present `section` or `slice`, `class`, `weight`,
// `touches_border`, `centroid_x`, `centroid_y`, `color_r`, `color_g`, `color_b`. A table of one column
// without a header holds areas. Lines that are empty or begin with # are skipped. `file` is for messages.
// Throws Error "malformed-row" with file:line, "no-column", "no-particles".
Profiles read_profiles(const std::string& text, const std::string& file, const ProfileUnit& unit);

}  // namespace terrazzo
