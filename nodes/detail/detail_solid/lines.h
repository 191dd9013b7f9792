// Long thin structures: cracks and veins of the material, and scratches of the picture.
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Values of deviation about 1 around 0, and which of them are known.
struct LinePicture {
  cv::Mat value;  // CV_32F; 0 where unknown
  cv::Mat known;  // CV_32F; 0 or 1
  // Chance is drawn within each class: CV_8U.
  cv::Mat kind;
  // CV_32FC3: normal of a near outline, of length 0 to 1, and 1. Only lines that cross it count, because
  // others are its rim. All count where the third value is 0.
  cv::Mat rim;
};

struct LineOptions {
  double along = 3;     // standard deviation of the filter along a line, pixels
  double across = 0.8;  // and across
  int angles = 16;
  // Only lines that deviate from a straight one by at most `bend`, standard deviation in pixels, and are at
  // least `length` long, count.
  double bend = 1e9, length = 0;
  float clear = 1;  // least score, relative to the clearest line of chance
};

struct Line {
  std::vector<cv::Point> pixels;
  std::vector<std::uint8_t> angle;  // of each pixel: π angle / angles from the right downwards
  float score = 0;                  // sum of how far the filter exceeds its limit
  float length = 0;                 // pixels
  float bend = 0;                   // standard deviation from a straight line, pixels
  cv::Point2f center, direction;    // of the straight line
  int kind = 0;                     // of most pixels
  bool dark = false;
};

// Dark and light lines of each kind. Elongated second differences in all directions, relative to their
// deviation in white noise; their ridges (Canny 1986, Steger 1998) above a limit are joined to lines. The
// limit comes from the same search in a picture that has the same values and the same spectrum but no lines,
// because its phases are random (surrogate data: Theiler et al. 1992).
// A line counts if it is `clear` times as clear as the clearest there, and a kind has lines if at least three
// are twice as clear.
std::vector<Line> find_lines(const LinePicture&, const LineOptions&, std::uint64_t seed, const Work& = {});

// Finds lines in the middle of the first section, at most 1,024 pixels square, measures them and takes their
// pixels out of the phases.
// - Scratches are lines of the binder that are straight over at least 24 pixels.
// - All other lines are sheets of their phase, of whichever sign makes more of them. A binder with scratches
//   has none, because short pieces of scratches look like them. Neither has a binder with zones, because
//   veins of one zone would run through the other.
// Within 8 pixels of an outline, only lines that cross it count; others are rims. Each profile gets its own
// density. `noise`: what was taken out of the photograph's lightness before, sRGB-encoded; empty: nothing.
// Where it was taken out, it left patterns of its own.
void split_lines(Phases&, const Labels&, const std::vector<float>& noise, Detail&, std::uint64_t seed,
                 const Work& = {});

}  // namespace terrazzo::detail_solid
