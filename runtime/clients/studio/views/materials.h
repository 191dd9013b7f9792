// The material graphs that come with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terrazzo::studio {

struct Material {
  std::string name;   // of the file, without its extension
  std::string title;  // the graph's name
  std::string doc;    // the comment at the beginning of the file
  std::filesystem::path file;
  std::filesystem::path picture;  // JPEG; "" if there is none
};

// Sorted by title, the default material first. Empty if no graphs are installed with the program.
std::vector<Material> materials();

// The material with this name. Throws Error "unknown-material".
Material material(const std::string& name);

}  // namespace terrazzo::studio
