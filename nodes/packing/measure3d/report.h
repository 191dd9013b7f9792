// Tables and figure of what was measured.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/packing/measure3d/bodies.h"
#include "nodes/packing/measure3d/correlation.h"
#include "nodes/packing/measure3d/phase_measures.h"
#include "nodes/packing/measure3d/subvolumes.h"
#include "nodes/packing/measure3d/surfaces.h"

namespace terrazzo::measure3d {

// Shares of the particles, of the contacts, of chords or of the phase's volume, in ranges of one measure.
struct Histogram {
  std::string name, unit;
  std::vector<double> edges, share;  // n + 1 and n
  std::vector<double> expected;      // shares if orientations are random; empty for other measures
};

struct Findings {
  double volume = 0;          // of the box, mm³
  std::vector<Body> bodies;   // all particles
  std::vector<char> counted;  // whether each belongs to the phase and is complete
  std::vector<Touch> touches;
  std::vector<int> neighbors;            // number of contacts of each body
  std::vector<double> contact_area;      // of each body, mm²
  double gap = 0;                        // within which meshes touch, mm; 0 for voxels
  std::optional<double> voxel_fraction;  // of the phase
  std::optional<PhaseMeasures> phase;    // unless it fills the box or is empty
  std::vector<PhaseMeasures> phases;     // each label, or the phase and the rest
  std::vector<Interface> interfaces;     // of these
  std::optional<Correlation> correlation;
  std::optional<Representative> representative;
};

// Sets neighbors and contact_area from touches.
void count_contacts(Findings&);

std::vector<Histogram> histograms_of(const Findings&);
// Columns: measure, value, error, unit. `error` is the standard error of means, empty where it is not known.
Table summary_of(const Findings&);
Table body_table(const Findings&);
Table histogram_table(const std::vector<Histogram>&);
Table contact_table(const Findings&);
Table correlation_table(const Findings&);
Table subvolume_table(const Findings&);
// Columns: phase, then one per measure.
Table phase_table(const Findings&);
// Columns: a, b, area mm², area per volume 1/mm.
Table interface_table(const Findings&);
Image figure_of(const Findings&, const std::vector<Histogram>&);

}  // namespace terrazzo::measure3d
