#include "nodes/segment/model_pool.h"

#include "graph/diagnostic.h"

namespace terrazzo::segment {

ModelPool::ModelPool(std::string bytes, std::string hint) : bytes_(std::move(bytes)), hint_(std::move(hint)) {
  free_.push_back(take());
}

void ModelPool::refuse(const std::string& why) const {
  throw Error("bad-model", "the network cannot be used: " + why, hint_);
}

std::unique_ptr<cv::dnn::Net> ModelPool::take() {
  {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      auto net = std::move(free_.back());
      free_.pop_back();
      return net;
    }
  }
  try {
    auto net = std::make_unique<cv::dnn::Net>(cv::dnn::readNetFromONNX(bytes_.data(), bytes_.size()));
    if (net->empty()) refuse("it is empty");
    net->setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    return net;
  } catch (const cv::Exception& e) {
    refuse(e.err);
  }
}

cv::Mat ModelPool::run(const cv::Mat& blob) {
  auto net = take();
  cv::Mat out;
  try {
    net->setInput(blob);
    out = net->forward().clone();
  } catch (const cv::Exception& e) {
    refuse(e.err);
  }
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(net));
  return out;
}

}  // namespace terrazzo::segment
