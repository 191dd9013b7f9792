#include "nodes/segment/model_pool.h"

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
        std::swap(one, free_.back());
        auto copy = std::move(free_.back());
        free_.pop_back();
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
  return out;
}

}  // namespace terrazzo::segment
