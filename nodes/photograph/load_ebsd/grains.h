// Grains of an EBSD map: regions of one phase within which neighbors differ little in orientation.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/table.h"
#include "nodes/photograph/load_ebsd/ebsd_map.h"
#include "runtime/work.h"

namespace terrazzo::load_ebsd {

struct GrainRule {
  double misorientation = 10;        // degrees: neighbors that differ by less belong to one grain
  float min_confidence = -1;         // points below it count as not indexed (.ang)
  float max_deviation = 180;         // degrees: points above it count as not indexed (.ctf)
  int min_pixels = 1;                // smaller grains are removed
  int fill = 0;                      // pixels without a grain that are this close to one join it
  std::vector<std::int64_t> phases;  // numbers from 1 of those that are particles; empty: all
};

struct Grain {
  int phase = 0;            // position in EbsdMap::phases
  std::int64_t pixels = 0;  // those with an orientation; `fill` adds others
  Eigen::Quaternionf mean = Eigen::Quaternionf::Identity();
  double spread = 0;   // mean disorientation from the mean orientation, degrees
  double quality = 0;  // mean
};

struct Grains {
  Labels labels;              // class: position of the phase
  std::vector<Grain> grains;  // that of number k at k − 1
};

// Grains are connected through the sides of pixels, and numbered by their first pixel. Throws Error
// "bad-value" for a phase that the map lacks, "no-particles" if there is no grain, and Cancelled.
Grains find_grains(const EbsdMap&, const GrainRule&, const Work&);

// A row per grain: number, phase, size, mean orientation.
Table grain_table(const EbsdMap&, const Grains&);

// Colors of the direction normal to the map (direction_color), or the pattern quality as gray. Black: not
// indexed.
Image orientation_image(const EbsdMap&, const Work&);
Image quality_image(const EbsdMap&);

}  // namespace terrazzo::load_ebsd
