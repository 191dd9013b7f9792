// Small valid files in every format of every reader, as seeds for mutation.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace terrazzo::torture {

struct InputSeed {
  std::string reader;                        // such as "LoadVolume.vdb": a node or function, and a format
  std::map<std::string, std::string> files;  // content by name; the reader opens the first
};

// Writes files below `folder`, which must exist. Starts threads, so call it in a separate process.
void write_input_seeds(const std::filesystem::path& folder, const std::filesystem::path& source);
std::vector<InputSeed> read_input_seeds(const std::filesystem::path& folder);

}  // namespace terrazzo::torture
