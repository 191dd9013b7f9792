// Runs LoadVolume on a file or glob.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tests/support/run_node.h"

namespace terrazzo::test {

inline NodeRun load_volume(const std::filesystem::path& path, std::map<std::string, std::string> more = {}) {
  more["path"] = path.string();
  return run_node("LoadVolume", {}, more);
}

}  // namespace terrazzo::test
