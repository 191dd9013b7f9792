// The bands of a two-dimensional steerable pyramid on a torus, in the frequency domain.
#pragma once

#include <complex>
#include <vector>

#include "nodes/common/lane_fft.h"

namespace terrazzo {

// One band: its transfer function, and the cropped grid on which it is still sampled above its Nyquist rate.
struct Band {
  int scale = 0;  // 0: the high-pass residue, 1 … scales: oriented bands, scales + 1: the low-pass residue
  int orientation = 0;              // 0 … 3
  bool odd = false;                 // transfer i·gain (odd filter), else gain
  int width = 0, height = 0;        // of the cropped grid
  std::vector<float> gain;          // of its coefficients, x fastest
  std::vector<std::size_t> source;  // where each lies in the full spectrum; unused where gain is 0
};

// Simoncelli and Freeman 1995: a tight frame, Σ |transfer|² = 1. Radial windows are half-cosines in log
// frequency, an octave wide; four orientations by cos³. Frequencies are cycles per pixel, so bands mean the
// same for pictures of any size. With orientations = 1 bands are even and take in all directions.
std::vector<Band> pyramid_bands(int width, int height, int scales, int orientations = 4);
// Radians per pixel from which on a scale's transfer is 0: π at scale 1, an octave lower at each further one.
double upper_edge(int scale);
// The radial window of a scale, at r radians per pixel.
double radial_gain(int scale, int scales, double r);
// Transfer of a band at a frequency in radians per pixel, less the factor i of odd bands.
double band_gain(int scale, int orientation, int scales, double u, double v);
// The scales that fit into a picture of that smallest side: the low-pass residue keeps at least 4 × 4
// coefficients.
int pyramid_scales(int smallest_side, int most = 4);

// spectrum (unnormalised) → band on its cropped grid, real values in re and im alike. `out` has width·height
// elements.
void extract_band(const Band&, const LaneFft2& crop, const LaneComplex* spectrum, std::size_t full_count,
                  LaneComplex* out, std::vector<LaneComplex>& scratch);
// The adjoint: adds what the band gives back to the spectrum. `values` is overwritten.
void add_band(const Band&, const LaneFft2& crop, LaneComplex* values, std::size_t full_count,
              LaneComplex* spectrum, std::vector<LaneComplex>& scratch);

}  // namespace terrazzo
