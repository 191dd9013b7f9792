#include "nodes/media/micrograph/recommend.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/media/micrograph/find_phases.h"

namespace terrazzo::media {
namespace {

constexpr int kLooked = 512;        // pixels along each side
constexpr int kLeastPiece = 20;     // pixels: smaller pieces have no shape
constexpr double kSurrounds = 0.9;  // share of a phase's largest piece
// Between the micrographs without particles that were tried (0.4 to 0.81) and the photographs of particles
// (0.83 to 0.94).
constexpr double kCompact = 0.82;

// Area of the convex hull of pixels, from the first and the last one in each row.
double hull_area(const std::vector<cv::Point>& ends) {
  std::vector<cv::Point> hull;
  cv::convexHull(ends, hull);
  // Pixels are squares around these points: the Minkowski sum of the hull and a square.
  const cv::Rect box = cv::boundingRect(hull);
  return cv::contourArea(hull) + (box.width - 1) + (box.height - 1) + 1;
}

double compactness_of(const cv::Mat1b& phase) {
  cv::Mat1i pieces, stats;
  cv::Mat1d centers;
  const int count = cv::connectedComponentsWithStats(phase, pieces, stats, centers, 4, CV_32S);
  std::vector<std::vector<cv::Point>> ends(count);
  for (int y = 0; y < pieces.rows; ++y)
    for (int x = 0; x < pieces.cols; ++x) {
      const int piece = pieces(y, x);
      if (piece > 0 &&
          (x == 0 || x + 1 == pieces.cols || pieces(y, x - 1) != piece || pieces(y, x + 1) != piece))
        ends[piece].emplace_back(x, y);
    }
  double all = 0, largest = 0, filled = 0, counted = 0;
  for (int piece = 1; piece < count; ++piece) {
    const double area = stats(piece, cv::CC_STAT_AREA);
    all += area;
    largest = std::max(largest, area);
    if (area < kLeastPiece) continue;
    filled += area * area / hull_area(ends[piece]);
    counted += area;
  }
  return counted == 0 || largest > kSurrounds * all ? 0 : filled / counted;
}

Image middle_of(const Image& from) {
  const int width = std::min(from.width, kLooked), height = std::min(from.height, kLooked);
  Image out(width, height, 1, from.pixel_size);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out.at(x, y, 0) = from.at((from.width - width) / 2 + x, (from.height - height) / 2 + y, 0);
  return out;
}

}  // namespace

double compactness(const PhaseMap& map) {
  double most = 0;
  for (int p = 0; p < map.phases; ++p) {
    cv::Mat1b phase(map.height, map.width);
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) phase(y, x) = map.at[map.index(x, y)] == p;
    most = std::max(most, compactness_of(phase));
  }
  return most;
}

Recommendation recommend(const Image& image, const Work& work) {
  FoundPhases found;
  try {
    found = find_phases(middle_of(image), {}, {}, work);
  } catch (const Error& e) {
    if (e.diagnostic().code != "one-phase") throw;
    return {false, "The gray levels of the picture do not separate phases."};
  }
  const double compact = compactness(found.map);
  const int percent = round_nearest(100 * compact);
  if (compact > kCompact)
    return {false,
            fmt::format("The picture has separate pieces that fill {} % of their convex hulls.", percent)};
  return {true, fmt::format("The picture has {} gray levels, and none of them forms compact pieces.",
                            found.map.phases)};
}

}  // namespace terrazzo::media
