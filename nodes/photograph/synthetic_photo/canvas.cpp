#include "nodes/photograph/synthetic_photo/canvas.h"

#include <opencv2/imgproc.hpp>

namespace terrazzo::synthetic_photo {

void blur(std::vector<float>& field, int width, int height, double sigma) {
  if (sigma < 0.2) return;
  cv::Mat m(height, width, CV_32F, field.data()), out;
  // Wide kernels run on a reduced copy: only smooth results are wanted of them.
  const int step = sigma > 8 ? static_cast<int>(sigma / 4) : 1;
  if (step > 1) {
    cv::Mat small;
    cv::resize(m, small, cv::Size(std::max(1, width / step), std::max(1, height / step)), 0, 0,
               cv::INTER_AREA);
    cv::GaussianBlur(small, small, cv::Size(0, 0), sigma / step, sigma / step, cv::BORDER_REPLICATE);
    cv::resize(small, out, m.size(), 0, 0, cv::INTER_LINEAR);
  } else {
    cv::GaussianBlur(m, out, cv::Size(0, 0), sigma, sigma, cv::BORDER_REPLICATE);
  }
  out.copyTo(m);
}

}  // namespace terrazzo::synthetic_photo
