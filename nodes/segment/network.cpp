#include "nodes/segment/network.h"

#include <algorithm>
#include <mutex>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

// The model's bytes, in the read-only data of the library.
__asm__(
    ".section .rodata\n"
    ".balign 16\n"
    "terrazzo_segment_model:\n"
    ".incbin \"" TERRAZZO_SEGMENT_MODEL
    "\"\n"
    "terrazzo_segment_model_end:\n"
    ".previous\n");
extern "C" const char terrazzo_segment_model[], terrazzo_segment_model_end[];

namespace terrazzo::segment {
namespace {

constexpr int kMultiple = 32;  // the network halves the resolution five times
constexpr int kCore = 512;     // rows and columns of a tile that are kept
constexpr int kMargin = 64;    // around them, so that the tile's border does not show

int up_to_multiple(int n) { return (n + kMultiple - 1) / kMultiple * kMultiple; }

cv::Mat encoded_section(const Image& image, int section) {
  cv::Mat m(image.height, image.width, CV_32FC3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3f c = linear_to_srgb(image.at(x, y, section).cwiseMax(0.0f).cwiseMin(1.0f));
      m.at<cv::Vec3f>(y, x) = cv::Vec3f(c[0], c[1], c[2]);
    }
  return m;
}

Error bad_model(const std::string& why) {
  return Error(
      "bad-model", "the network cannot be used: " + why,
      "use an ONNX model with one input (1, 3, h, w) and one output (1, 4, h, w): inside, border, distance, "
      "not material");
}

}  // namespace

std::string built_in_model() { return {terrazzo_segment_model, terrazzo_segment_model_end}; }

// OpenCV's networks keep buffers, so every thread needs its own. They are reused.
struct Network::Model {
  std::string bytes;
  std::mutex mutex;
  std::vector<std::unique_ptr<cv::dnn::Net>> free;

  std::unique_ptr<cv::dnn::Net> take() {
    {
      const std::lock_guard lock(mutex);
      if (!free.empty()) {
        auto net = std::move(free.back());
        free.pop_back();
        return net;
      }
    }
    try {
      auto net = std::make_unique<cv::dnn::Net>(cv::dnn::readNetFromONNX(bytes.data(), bytes.size()));
      if (net->empty()) throw bad_model("it is empty");
      net->setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
      return net;
    } catch (const cv::Exception& e) {
      throw bad_model(e.err);
    }
  }
  void give(std::unique_ptr<cv::dnn::Net> net) {
    const std::lock_guard lock(mutex);
    free.push_back(std::move(net));
  }
  cv::Mat run(const cv::Mat& tile) {
    auto net = take();
    cv::Mat out;
    try {
      net->setInput(cv::dnn::blobFromImage(tile));
      out = net->forward().clone();
    } catch (const cv::Exception& e) {
      throw bad_model(e.err);
    }
    if (out.dims != 4 || out.size[0] != 1 || out.size[1] != 4 || out.size[2] != tile.rows ||
        out.size[3] != tile.cols)
      throw bad_model("its output does not have four maps of the input's size");
    give(std::move(net));
    return out;
  }
};

Network::Network(std::string bytes) : model_(std::make_unique<Model>()) {
  model_->bytes = std::move(bytes);
  model_->give(model_->take());
}
Network::~Network() = default;

NetworkMaps Network::operator()(const Image& image, int section, double scale, const Work& work) const {
  cv::setNumThreads(1);  // tiles are the unit of parallel work
  cv::Mat picture = encoded_section(image, section);
  const int w = std::max(1, static_cast<int>(std::lround(image.width * scale))),
            h = std::max(1, static_cast<int>(std::lround(image.height * scale)));
  if (w != image.width || h != image.height)
    cv::resize(picture, picture, cv::Size(w, h), 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  // Mirrored margins make each side a multiple of 32 and at least 64 pixels.
  const int padded_w = std::max(2 * kMultiple, up_to_multiple(w)),
            padded_h = std::max(2 * kMultiple, up_to_multiple(h));
  cv::Mat padded;
  const int kind = w > 1 && h > 1 ? cv::BORDER_REFLECT_101 : cv::BORDER_REPLICATE;
  cv::copyMakeBorder(picture, padded, 0, padded_h - h, 0, padded_w - w, kind);

  cv::Mat maps[4];
  for (auto& m : maps) m.create(padded_h, padded_w, CV_32F);
  const int columns = (padded_w + kCore - 1) / kCore, rows = (padded_h + kCore - 1) / kCore;
  work.parallel(static_cast<std::size_t>(columns) * rows, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const int x0 = static_cast<int>(t % columns) * kCore, y0 = static_cast<int>(t / columns) * kCore;
      const cv::Rect core(x0, y0, std::min(kCore, padded_w - x0), std::min(kCore, padded_h - y0));
      const int left = std::max(0, x0 - kMargin), top = std::max(0, y0 - kMargin);
      const cv::Rect seen(left, top, std::min(padded_w, x0 + core.width + kMargin) - left,
                          std::min(padded_h, y0 + core.height + kMargin) - top);
      const cv::Mat out = model_->run(padded(seen));
      for (int k = 0; k < 4; ++k) {
        const cv::Mat plane(seen.height, seen.width, CV_32F, const_cast<float*>(out.ptr<float>(0, k)));
        plane(cv::Rect(x0 - left, y0 - top, core.width, core.height)).copyTo(maps[k](core));
      }
    }
  });
  NetworkMaps result;
  result.width = image.width, result.height = image.height;
  std::vector<float>* planes[4] = {&result.inside, &result.border, &result.distance, &result.not_material};
  for (int k = 0; k < 4; ++k) {
    cv::Mat m = maps[k](cv::Rect(0, 0, w, h));
    planes[k]->resize(static_cast<std::size_t>(image.width) * image.height);
    cv::Mat out(image.height, image.width, CV_32F, planes[k]->data());
    if (m.size() == out.size())
      m.copyTo(out);
    else
      cv::resize(m, out, out.size(), 0, 0, cv::INTER_LINEAR);
  }
  return result;
}

}  // namespace terrazzo::segment
