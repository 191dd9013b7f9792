// EBSD maps from files: the orientation and phase of a crystal at each point of a plane section.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/photograph/load_ebsd/crystal.h"
#include "runtime/memory.h"

namespace terrazzo::load_ebsd {

struct Phase {
  std::string name;
  Symmetry symmetry;
};

struct MapPoint {
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  std::int32_t phase = -1;  // position in EbsdMap::phases; −1: not indexed
  float quality = 0;        // of the pattern: image quality (.ang) or band contrast (.ctf)
  float confidence = 0;     // of the indexing: confidence index (.ang) or 0 (.ctf)
  float deviation = 0;      // mean angular deviation in degrees (.ctf) or 0 (.ang)
};

struct EbsdMap {
  int width = 0, height = 0;  // square pixels
  double pixel_size = 1;      // µm
  std::vector<Phase> phases;
  std::vector<MapPoint> points;  // rows from the smallest y
  std::int64_t missing = 0;      // places of the grid for which the file has no point; they are not indexed
};

// Bytes that reading takes for each byte of text, an upper bound: the shortest line of a point has 16
// characters.
inline constexpr double kMapBytesPerByte = 1 + (2.0 * sizeof(MapPoint) + 6 * sizeof(double)) / 16;

// The content of an EDAX/TSL .ang file, or of an Oxford/HKL .ctf file. The coordinates of the points say
// where they are, so points may be in any order, and missing; what the header says about the grid must agree.
// Points on a hexagonal grid, or with different steps along x and y, are resampled: each square pixel takes
// the nearest point. Throws Error "unreadable-file" for a header without what is needed, "malformed-row" with
// the first line that is wrong or contradicts the header, and "too-large" beyond `memory` bytes.
EbsdMap read_ang(std::string_view text, const std::string& file, std::uint64_t memory = available_memory());
EbsdMap read_ctf(std::string_view text, const std::string& file, std::uint64_t memory = available_memory());

}  // namespace terrazzo::load_ebsd
