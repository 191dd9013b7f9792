// Trained models in ONNX, one copy for each thread that uses them.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <opencv2/dnn.hpp>
#include <string>
#include <vector>

namespace terrazzo::segment {

// OpenCV's networks keep buffers, so every thread needs its own. They are reused for blobs of the same shape
// only: after a change of shape, OpenCV 4.6 computes instance normalization with the factors of the former
// shape. Copies that were not used for longest are dropped while the others' blobs have more than
// kMostPixels.
class ModelPool {
 public:
  static constexpr std::size_t kMostPixels = 2'500'000;  // about 1.5 GB of buffers
  // Throws Error "bad-model" with the reason and `hint`.
  ModelPool(std::string bytes, std::string hint);
  // The output for a blob; a copy. May be called from several threads. Throws Error "bad-model".
  cv::Mat run(const cv::Mat& blob);
  [[noreturn]] void refuse(const std::string& why) const;
  // Of the blobs that the unused copies have buffers for, all items of a batch together.
  std::size_t pixels_kept() const;

 private:
  struct Copy {
    cv::dnn::Net net;
    std::vector<int> shape;  // of the blobs that it has seen; empty: none yet
  };
  std::unique_ptr<Copy> read() const;
  std::unique_ptr<Copy> take(const std::vector<int>& shape);

  std::string bytes_, hint_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Copy>> free_;
};

}  // namespace terrazzo::segment
