// How much the volume fraction of a phase varies between subvolumes, and the size of a representative volume.
#pragma once

#include <vector>

#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

struct Subvolumes {
  double edge = 0;                  // of the cubes, mm; of equal volume if the voxels are not cubes
  double count = 0;                 // how many fit into the volume without overlap
  double deviation = 0, error = 0;  // standard deviation of their volume fractions, and its standard error
  double expected = 0;              // the deviation that follows from the integral range
};

struct Representative {
  // Integral range A: the variance of the volume fraction φ of a large volume V is φ(1 − φ)A/V. mm³, with
  // standard error.
  double integral_range = 0, integral_range_error = 0;
  double fraction_error = 0;  // standard deviation of φ in boxes like this, if nothing held it fixed
  // Edge of a cube in which two standard deviations of φ are `precision`·φ, mm, with standard error.
  double edge = 0, edge_error = 0;
  std::vector<Subvolumes> table;  // by decreasing edge
};

// The integral range is the mean of the spectral density over the waves of up to two periods per edge of the
// box, divided by φ(1 − φ) (Lantuéjoul 1991; Kanit et al. 2003). All zero if φ is 0 or 1.
Representative representative_volume(const Raster&, double precision, const Work&);

}  // namespace terrazzo::measure3d
