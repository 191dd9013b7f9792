#include "nodes/packing/measure3d/phase_measures.h"

namespace terrazzo::measure3d {

std::vector<PhaseMeasures> measure_classes(const Classes& classes, std::uint64_t memory, const Work& work) {
  const auto chords = chord_lengths(classes, work.part(0, 0.1));
  const auto cubes = count_cubes(classes, work.part(0.1, 0.15));
  const auto percolation = percolation_of(classes, memory, work.part(0.15, 0.2));
  const auto diameters = local_thickness(classes, memory, work.part(0.2, 0.95));
  const auto thickness = thickness_distributions(classes, diameters, work.part(0.95, 1));
  std::vector<PhaseMeasures> out(classes.count());
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = {classes.name[k],
              static_cast<double>(classes.voxels[k]) / static_cast<double>(classes.of.size()),
              minkowski_densities(cubes[k], classes.box.spacing, classes.faces_only[k]),
              chords[k],
              classes.box.spacing,
              thickness[k],
              percolation[k]};
  return out;
}

}  // namespace terrazzo::measure3d
