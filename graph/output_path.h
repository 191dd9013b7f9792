// Paths of files that nodes write.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

// Whether a path is absolute, empty, or leads out of the folder that it is relative to.
inline bool leaves_folder(const std::filesystem::path& path) {
  const std::filesystem::path normal = path.lexically_normal();
  return normal.is_absolute() || normal.empty() || *normal.begin() == "..";
}

// Without the difference between a and A, which many file systems do not make.
inline std::string without_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// Whether a path below the output folder names a file that the program itself writes there: the report of a
// run, or the plan, table and contact sheet of a sweep.
inline bool is_reserved_output(const std::filesystem::path& path) {
  const std::string name = without_case(path.lexically_normal().generic_string());
  return name == "report.json" || name == "sweep.json" || name == "sweep.csv" || name == "sweep.png";
}

}  // namespace terrazzo
