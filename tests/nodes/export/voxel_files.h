// Exports small volumes, and reads what was written.
#pragma once

#include <gtest/gtest.h>

#include <sstream>

#include "tests/nodes/export/export_support.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo::test {
namespace fs = std::filesystem;

using Inputs = std::multimap<std::string, Value>;
using Parameters = std::map<std::string, std::string>;

inline fs::path exported(const std::string& name, Inputs inputs, Parameters parameters = {}) {
  const fs::path out = temporary_folder();
  parameters["path"] = name;
  run_node("Export", inputs, parameters, out);
  return out / name;
}

inline Volume loaded(const fs::path& file, Parameters parameters = {}) {
  parameters["path"] = file.string();
  return run_node("LoadVolume", {}, parameters).output<Volume>("volume");
}

template <class Grid>
void expect_formula(const Volume& v, const std::string& name, auto&& value) {
  const auto grid = v.find<Grid>(name);
  ASSERT_TRUE(grid) << name;
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x)
        ASSERT_EQ(grid->tree().getValue(openvdb::Coord(x, y, z)), value(x, y, z))
            << x << " " << y << " " << z;
}

inline std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream in(content_of(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace terrazzo::test
