// How well slices of a solid agree with the pictures, beside how much parts of the pictures differ.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/media/annealing/anneal.h"

namespace terrazzo::annealing {

// A number, or a function of the distance, for one phase.
struct Agreement {
  std::string measure, unit;
  int picture = 0, phase = 0;
  std::vector<double> of_picture, of_solid;  // one value, or one for each distance in pixels from 0
  std::vector<double> low, high;             // least and greatest of the picture's tiles
  double difference = 0;                     // of numbers; mean absolute one of functions
  double scatter = 0;  // the same of the tiles: standard deviation, mean absolute difference
};

// The solid's slices across the axes that show a picture, and the picture. Cluster functions, Euler numbers
// and connections depend on the size of the window, so they are those of tiles of the slices' size, at most
// half the picture's. The picture counts up to 2,048 pixels along each side.
std::vector<Agreement> compare_slices(const std::vector<media::PhaseMap>&, const AnnealOptions&, const Solid&,
                                      const Work&);

Table agreement_table(const std::vector<Agreement>&);

// A picture of phases with a caption.
struct Shown {
  std::string caption;
  media::PhaseMap map;
};
// The first tile of each picture and the middle slices across x, y and z, all of one size.
std::vector<Shown> show(const std::vector<media::PhaseMap>&, const AnnealOptions&, const Solid&);
// These pictures above the functions of the first picture.
Image agreement_figure(const std::vector<Agreement>&, const std::vector<Shown>&);

}  // namespace terrazzo::annealing
