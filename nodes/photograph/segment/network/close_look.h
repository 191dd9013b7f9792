// The second network: draws the outline of what a candidate shows.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "nodes/photograph/segment/network/close_up.h"

namespace terrazzo::segment {

constexpr int kCloseUpsTogether = 16;  // seen at once

class CloseLook {
 public:
  // `bytes`: an ONNX model with input (n, 10, 48, 48), close-ups, and output (n, 1, 48, 48), the logit that a
  // pixel belongs to the particle. Throws Error "bad-model".
  explicit CloseLook(std::string bytes);
  ~CloseLook();
  CloseLook(const CloseLook&) = delete;
  CloseLook& operator=(const CloseLook&) = delete;

  // The logits of each close-up. May be called from several threads.
  std::vector<cv::Mat> operator()(std::span<const CloseUp>) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

// The one that comes with the program, trained on candidates of synthetic pictures;
// nodes/photograph/segment/training describes how.
const CloseLook& built_in_close_look();

// What has positive logits, in one piece with as much of the candidate as possible, without holes; empty if
// that is nothing. `section`: width and height of the section in pixels.
Cutout redrawn(const Cutout& candidate, const CloseUp&, const cv::Mat& logits, const cv::Size& section);
// The same in a larger section of which that one is a reduction: the logits are interpolated there. `piece`:
// from redrawn().
Cutout enlarged(const Cutout& piece, const CloseUp&, const cv::Mat& logits, const cv::Size& section,
                const cv::Size& larger);

}  // namespace terrazzo::segment
