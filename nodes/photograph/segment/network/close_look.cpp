#include "nodes/photograph/segment/network/close_look.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/model_pool.h"

// The model's bytes, in the read-only data of the library.
__asm__(
    ".section .rodata\n"
    ".balign 16\n"
    "terrazzo_segment_close_look:\n"
    ".incbin \"" TERRAZZO_SEGMENT_CLOSE_LOOK
    "\"\n"
    "terrazzo_segment_close_look_end:\n"
    ".previous\n");
extern "C" const char terrazzo_segment_close_look[], terrazzo_segment_close_look_end[];

namespace terrazzo::segment {

struct CloseLook::Model : ModelPool {
  using ModelPool::ModelPool;
};

CloseLook::CloseLook(std::string bytes)
    : model_(std::make_unique<Model>(
          std::move(bytes),
          "use an ONNX model with one input (n, 10, 48, 48) and one output (n, 1, 48, 48)")) {}
CloseLook::~CloseLook() = default;

std::vector<cv::Mat> CloseLook::operator()(std::span<const CloseUp> close_ups) const {
  constexpr std::size_t kPixels = static_cast<std::size_t>(kCloseUp) * kCloseUp;
  std::vector<cv::Mat> out;
  const int shape[] = {kCloseUpsTogether, kCloseUpPlanes, kCloseUp, kCloseUp};
  cv::Mat blob(4, shape, CV_32F);  // of one shape, so that copies of the model are shared
  for (std::size_t first = 0; first < close_ups.size(); first += kCloseUpsTogether) {
    const auto part =
        close_ups.subspan(first, std::min<std::size_t>(kCloseUpsTogether, close_ups.size() - first));
    std::fill_n(blob.ptr<float>(), blob.total(), 0.0f);
    for (std::size_t k = 0; k < part.size(); ++k)
      for (int p = 0; p < kCloseUpPlanes; ++p)
        std::memcpy(blob.ptr<float>(static_cast<int>(k), p), part[k].planes[p].data, kPixels * sizeof(float));
    cv::Mat seen = model_->run(blob);
    if (seen.total() != kCloseUpsTogether * kPixels)
      model_->refuse("its output does not have one map for each close-up");
    for (std::size_t k = 0; k < part.size(); ++k)
      out.push_back(cv::Mat(kCloseUp, kCloseUp, CV_32F, seen.ptr<float>() + k * kPixels).clone());
  }
  return out;
}

const CloseLook& built_in_close_look() {
  static const CloseLook look(std::string(terrazzo_segment_close_look, terrazzo_segment_close_look_end));
  return look;
}

Cutout redrawn(const Cutout& candidate, const CloseUp& seen, const cv::Mat& logits, const cv::Size& section) {
  Cutout out;
  out.box = seen.square & cv::Rect(cv::Point(0, 0), section);
  cv::Mat logit;
  cv::resize(logits, logit, seen.square.size(), 0, 0, cv::INTER_LINEAR);
  const cv::Mat found = logit(out.box - seen.square.tl()) > 0;
  // The piece that shares most with the candidate.
  cv::Mat pieces, before(out.box.size(), CV_8U, cv::Scalar(0));
  const int count = cv::connectedComponents(found, pieces, 4, CV_32S);
  const cv::Rect shared = candidate.box & out.box;
  candidate.mask(shared - candidate.box.tl()).copyTo(before(shared - out.box.tl()));
  std::vector<int> common(count, 0);
  for (int y = 0; y < pieces.rows; ++y)
    for (int x = 0; x < pieces.cols; ++x) common[pieces.at<int>(y, x)] += before.at<std::uint8_t>(y, x);
  common[0] = 0;
  const auto best = std::max_element(common.begin(), common.end());
  if (*best == 0) return {};
  out.mask = (pieces == static_cast<int>(best - common.begin())) / 255;
  fill_holes_of(out.mask);
  return out;
}

Cutout enlarged(const Cutout& piece, const CloseUp& seen, const cv::Mat& logits, const cv::Size& section,
                const cv::Size& larger) {
  const double x = static_cast<double>(larger.width) / section.width,
               y = static_cast<double>(larger.height) / section.height;
  const auto scaled = [&](const cv::Rect& r) {
    const cv::Point from(round_nearest(r.x * x), round_nearest(r.y * y)),
        to(round_nearest(r.br().x * x), round_nearest(r.br().y * y));
    return cv::Rect(from, to);
  };
  const cv::Rect square = scaled(seen.square);
  const cv::Rect box = scaled(piece.box);
  Cutout out;
  out.box = square & box & cv::Rect(cv::Point(0, 0), larger);
  cv::Mat logit, near;
  cv::resize(logits, logit, square.size(), 0, 0, cv::INTER_LINEAR);
  // Only this piece: what lies within a pixel of the reduced one.
  cv::dilate(piece.mask, near, cv::Mat::ones(3, 3, CV_8U));
  cv::resize(near, near, box.size(), 0, 0, cv::INTER_NEAREST);
  out.mask = (logit(out.box - square.tl()) > 0) / 255;
  out.mask &= near(out.box - box.tl());
  fill_holes_of(out.mask);
  return out;
}

}  // namespace terrazzo::segment
