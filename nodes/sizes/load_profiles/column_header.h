// What the header of a column says: its name and its unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace terrazzo::load_profiles {

struct Unit {
  double mm = 1;  // of the length; 0: pixels
  int power = 0;  // 1 for lengths, 2 for areas; 0: not written, as in "um" for either
};

// "µm²", "um^2", "sq. microns", "mm2", "nm", "pixels". The micro sign, the Greek letter and "u" are the same.
std::optional<Unit> unit_of(std::string_view text);

// The letters, in small, digits and '%' of a text.
std::string plain_name(std::string_view text);

struct ColumnHeader {
  std::string name;       // small letters, digits and '%': "equivalentdiameter" of "Equivalent diameter [um]"
  std::string unit_text;  // as written; "" if the header names no unit
  std::optional<Unit> unit;  // that of the text; none if the text is no known unit
};

// Accepts "Area (µm²)", "Area [um^2]", "area_um2", "Area / mm²", "Area in mm²". Text in brackets that does
// not look like a unit is ignored: "Area (filled)".
ColumnHeader read_header(const std::string& header);

}  // namespace terrazzo::load_profiles
