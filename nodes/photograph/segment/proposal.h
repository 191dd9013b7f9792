// Particles that one source proposes.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/segment/color/particles.h"
#include "nodes/photograph/segment/network/network_particles.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// The confidences that scores of particles mean.
std::vector<double> confidences_of(std::vector<double> scores);

// The particles of all sections from one source, and what the network thinks of them. Sections are added in
// order, and filled or refined in the same order.
struct Proposal {
  Labels labels;
  std::vector<float> coverage;     // of each pixel of the stack
  std::vector<double> confidence;  // of label k at k − 1
  UndecidedPixels undecided;       // of the network's own particles
  double min_area = 0;
  std::int64_t specks = 0, speck_pixels = 0, holes = 0;

  void add(Particles2D found, const std::vector<double>& judged);
  void add_chosen(NetworkView::Found chosen);

  // Leaves no pixel of the section without a particle.
  void fill(int section, const Image& image, const NetworkView* judge, const Work& work);
  // Splits particles of two materials and corrects the outlines in a section by its colors.
  void refine(int section, const Image& image, const Work& work);

  // How much is expected to be right, and how much was found. Particles count by the length of their
  // outlines: counted by area, one boulder would decide; counted by number, the smallest would.
  struct Weight {
    double right = 0, found = 0;
  };
  Weight weight() const;
  // The share of the particles' pixels, weighted by confidence, where `other` has no particle; 0 without any.
  double left_out_by(const Proposal& other) const;

 private:
  std::vector<std::int32_t> filled_;  // by fill(), until its last section
  std::vector<double> filled_confidence_;

  void renumber(std::size_t plane);
};

}  // namespace terrazzo::segment
