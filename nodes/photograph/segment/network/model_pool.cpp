#include "nodes/photograph/segment/network/model_pool.h"

#include "graph/diagnostic.h"

namespace terrazzo::segment {

ModelPool::ModelPool(std::string bytes, std::string hint) : bytes_(std::move(bytes)), hint_(std::move(hint)) {
  free_.push_back(read());
}

void ModelPool::refuse(const std::string& why) const {
  throw Error("bad-model", "the network cannot be used: " + why, hint_);
}

std::unique_ptr<ModelPool::Copy> ModelPool::read() const {
  try {
    auto copy = std::make_unique<Copy>();
    copy->net = cv::dnn::readNetFromONNX(bytes_.data(), bytes_.size());
    if (copy->net.empty()) refuse("it is empty");
    copy->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    return copy;
  } catch (const cv::Exception& e) {
    refuse(e.err);
  }
}

std::unique_ptr<ModelPool::Copy> ModelPool::take(const std::vector<int>& shape) {
  {
    const std::lock_guard lock(mutex_);
    for (auto& one : free_)
      if (one->shape.empty() || one->shape == shape) {
        auto copy = std::move(one);
        free_.erase(free_.begin() + (&one - free_.data()));
        return copy;
      }
  }
  return read();
}

cv::Mat ModelPool::run(const cv::Mat& blob) {
  const std::vector<int> shape(blob.size.p, blob.size.p + blob.dims);
  auto copy = take(shape);
  copy->shape = shape;
  cv::Mat out;
  try {
    copy->net.setInput(blob);
    out = copy->net.forward().clone();
  } catch (const cv::Exception& e) {
    refuse(e.err);
  }
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(copy));
  // Pictures in tiles have blobs of many shapes. Those that were not used for longest go.
  while (free_.size() > 1 && pixels_kept() > kMostPixels) free_.erase(free_.begin());
  return out;
}

std::size_t ModelPool::pixels_kept() const {
  std::size_t sum = 0;
  for (const auto& one : free_)
    if (const auto& s = one->shape; s.size() == 4)
      sum += static_cast<std::size_t>(s[0]) * static_cast<std::size_t>(s[2]) * s[3];
  return sum;
}

}  // namespace terrazzo::segment
