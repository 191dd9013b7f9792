// Power diagrams whose cells have given volumes.
#pragma once

#include "nodes/packing/cells/effort.h"
#include "nodes/packing/cells/power_diagram.h"

namespace terrazzo::tessellation {

struct VolumeFit {
  double worst = 0;    // largest |V − wanted| / wanted of the last diagram
  int iterations = 0;  // Newton steps
};

// Changes the weights until every cell has its volume, by a damped Newton method for semi-discrete optimal
// transport (Kitagawa, Mérigot, Thibert 2019; Bourne, Kok, Roper, Spanjer 2020). `volume`: positive, in mm³,
// one per seed; they are scaled to fill the box. Ends when no cell is off by a fraction of more than
// `tolerance`. Starts from the given weights, or from equal ones if those leave a cell empty. Throws Error
// "not-converged" if the steps end before that, but not if the effort is spent; see VolumeFit::worst.
VolumeFit fit_volumes(Seeds& seeds, const std::vector<double>& volume, double tolerance, Effort& effort,
                      const Work& work = {});

// `rounds` times, moves every seed to the centroid of its cell and fits the volumes again: cells become
// rounder (Lloyd's algorithm). Intermediate diagrams are fitted coarsely.
VolumeFit fit_round_cells(Seeds& seeds, const std::vector<double>& volume, double tolerance, int rounds,
                          Effort& effort, const Work& work = {});

}  // namespace terrazzo::tessellation
