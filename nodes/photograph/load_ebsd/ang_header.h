// The header of an .ang file: lines that begin with #.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/photograph/load_ebsd/map_text.h"

namespace terrazzo::load_ebsd {

struct AngHeader {
  GridHeader grid;
  std::map<int, Phase> phases;  // by the number in the file
  double length = 1;            // µm per unit of lengths
  double angle = 1;             // radians per unit of angles

  // Position of each column in a row; npos: it has none.
  enum Column { Phi1, Phi, Phi2, X, Y, Quality, Confidence, PhaseNumber, Columns };
  std::array<std::size_t, Columns> at = {0, 1, 2, 3, 4, 5, 6, 7};
  bool names_columns = false;  // else the columns are those of all versions, of which old ones lack the last
};

// Reads up to the first line that does not begin with #. Lines that it does not know are ignored. Throws
// Error "unreadable-file" and "malformed-row".
AngHeader read_ang_header(Lines&);

}  // namespace terrazzo::load_ebsd
