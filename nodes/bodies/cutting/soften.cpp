#include "nodes/bodies/cutting/soften.h"

#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"

namespace terrazzo::section {

void soften(Vec3f* pixels, float* cover, const PixelGrid& grid, double sigma) {
  if (sigma < 0.2) return;
  const int margin = round_up(4 * sigma);
  const auto blur = [&](int type, void* data) {
    cv::Mat flat(grid.height, grid.width, type, data), wide;
    cv::copyMakeBorder(flat, wide, margin, margin, margin, margin,
                       grid.wrap ? cv::BORDER_WRAP : cv::BORDER_REPLICATE);
    cv::GaussianBlur(wide, wide, {0, 0}, sigma);
    wide(cv::Rect(margin, margin, grid.width, grid.height)).copyTo(flat);
  };
  blur(CV_32FC3, pixels);
  blur(CV_32F, cover);
}

}  // namespace terrazzo::section
