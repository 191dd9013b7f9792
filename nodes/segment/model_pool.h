// Trained models in ONNX, one copy for each thread that uses them.
#pragma once

#include <memory>
#include <mutex>
#include <opencv2/dnn.hpp>
#include <string>
#include <vector>

namespace terrazzo::segment {

// OpenCV's networks keep buffers, so every thread needs its own. They are reused.
class ModelPool {
 public:
  // Throws Error "bad-model" with the reason and `hint`.
  ModelPool(std::string bytes, std::string hint);
  // The output for a blob; a copy. May be called from several threads. Throws Error "bad-model".
  cv::Mat run(const cv::Mat& blob);
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  std::unique_ptr<cv::dnn::Net> take();

  std::string bytes_, hint_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<cv::dnn::Net>> free_;
};

}  // namespace terrazzo::segment
