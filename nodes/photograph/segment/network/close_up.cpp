#include "nodes/photograph/segment/network/close_up.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

cv::Rect square_around(const Cutout& region) {
  constexpr int kSmallest = 24;
  constexpr double kTimes = 2;
  const cv::Rect box = cv::boundingRect(region.mask) + region.box.tl();
  const int side = std::max(kSmallest, round_nearest(kTimes * std::max(box.width, box.height)));
  return {box.x + box.width / 2 - side / 2, box.y + box.height / 2 - side / 2, side, side};
}

}  // namespace

cv::Mat seen_close(const cv::Mat& map, const cv::Rect& square) {
  const cv::Rect there = square & cv::Rect(0, 0, map.cols, map.rows);
  cv::Mat part = map(there), out;
  if (there != square)
    cv::copyMakeBorder(part, part, there.y - square.y, square.br().y - there.br().y, there.x - square.x,
                       square.br().x - there.br().x, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  cv::resize(part, out, cv::Size(kCloseUp, kCloseUp), 0, 0,
             square.width > kCloseUp ? cv::INTER_AREA : cv::INTER_LINEAR);
  return out;
}

CloseUp close_up(const Cutout& region, const cv::Mat& picture, const ScaleView& view, const ScaleView& own) {
  CloseUp out;
  out.square = square_around(region);
  cv::Mat color = seen_close(picture, out.square), channels[3];
  cv::split(color, channels);
  double variance = 0;
  for (int k = 0; k < 3; ++k) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(channels[k], mean, deviation);
    out.planes[k] = channels[k] - mean[0];
    variance += deviation[0] * deviation[0] / 3;
  }
  const double gain = 1 / (std::sqrt(variance) + 0.02);
  for (int k = 0; k < 3; ++k) out.planes[k] *= gain;
  // The mask without the section around it: what the cutout leaves out is zero.
  cv::Mat mask(out.square.size(), CV_32F, cv::Scalar(0));
  const cv::Rect shared = region.box & out.square;
  region.mask(shared - region.box.tl()).convertTo(mask(shared - out.square.tl()), CV_32F);
  out.planes[3] = seen_close(mask, {0, 0, mask.cols, mask.rows});
  const NetworkMaps& maps = view.maps();
  out.planes[4] = seen_close(view.map(maps.inside), out.square);
  out.planes[5] = seen_close(view.map(maps.border), out.square);
  out.planes[6] = seen_close(view.map(maps.distance), out.square);
  out.planes[7] = seen_close(own.map(own.maps().inside), out.square);
  out.planes[8] = seen_close(own.map(own.maps().border), out.square);
  out.planes[9] = cv::Mat(kCloseUp, kCloseUp, CV_32F,
                          cv::Scalar(std::log2(out.square.width / static_cast<double>(kCloseUp))));
  return out;
}

}  // namespace terrazzo::segment
