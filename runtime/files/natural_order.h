// The order of file names in which slice_2 comes before slice_10.
#pragma once

#include <filesystem>
#include <string_view>

namespace terrazzo {

// Compares runs of digits as numbers of any length and everything else byte by byte, whatever the locale.
// Names that differ only in leading zeros are ordered as text, so only equal names are equal.
bool natural_less(std::string_view a, std::string_view b);

// The same for paths, component by component.
bool natural_path_less(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace terrazzo
