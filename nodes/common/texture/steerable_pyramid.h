// Bands of a two-dimensional steerable pyramid on a torus, in the frequency domain.
#pragma once

#include <complex>
#include <vector>

#include "nodes/common/texture/lane_fft.h"

namespace terrazzo {

// One band: its transfer function, and the cropped grid that still samples it above its Nyquist rate.
struct Band {
  int scale = 0;        // 0: high-pass residual; 1 … scales: oriented bands; scales + 1: low-pass residual
  int orientation = 0;  // 0 … 3
  bool odd = false;     // the transfer function is i·gain (odd filter), otherwise gain
  int width = 0, height = 0;        // of the cropped grid
  std::vector<float> gain;          // per coefficient, x fastest
  std::vector<std::size_t> source;  // index of each coefficient in the full spectrum; unused where gain is 0
};

// The bands of Simoncelli and Freeman 1995: a tight frame, Σ |transfer|² = 1. Radial windows are half-cosines
// in log frequency, one octave wide; four orientations by cos³. Frequencies are in cycles per pixel, so a
// band means the same for images of any size. With orientations = 1 the bands are even and isotropic.
std::vector<Band> pyramid_bands(int width, int height, int scales, int orientations = 4);
// Frequency in radians per pixel at which the transfer function of a scale reaches 0: π at scale 1, half as
// much at each further scale.
double upper_edge(int scale);
// The radial window of a scale, at r radians per pixel.
double radial_gain(int scale, int scales, double r);
// Transfer function of a band at a frequency in radians per pixel, without the factor i of odd bands.
double band_gain(int scale, int orientation, int scales, double u, double v);
// Number of scales for an image with that smallest side: the low-pass residual keeps at least 4 × 4
// coefficients.
int pyramid_scales(int smallest_side, int most = 4);

// Computes a band on its cropped grid from the unnormalized spectrum. re and im are independent real signals.
// `out` has width·height elements.
void extract_band(const Band&, const LaneFft2& crop, const LaneComplex* spectrum, std::size_t full_count,
                  LaneComplex* out, std::vector<LaneComplex>& scratch);
// The adjoint of extract_band: adds the band's contribution to the spectrum. Overwrites `values`.
void add_band(const Band&, const LaneFft2& crop, LaneComplex* values, std::size_t full_count,
              LaneComplex* spectrum, std::vector<LaneComplex>& scratch);

}  // namespace terrazzo
