// Small valid files of every kind that a reader takes, as the start of mutations.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace terrazzo::torture {

struct InputSeed {
  std::string reader;                        // "LoadVolume.vdb": a node, or a function, and a format
  std::map<std::string, std::string> files;  // content by name; the reader is given the first
};

// Writes files below `folder`, which must exist. Starts threads; so call it in a process of its own.
void write_input_seeds(const std::filesystem::path& folder, const std::filesystem::path& source);
std::vector<InputSeed> read_input_seeds(const std::filesystem::path& folder);

}  // namespace terrazzo::torture
