#include "nodes/photograph/segment/network/judge.h"

#include <cstring>

#include "nodes/photograph/segment/network/model_pool.h"

// The model's bytes, in the read-only data of the library.
__asm__(
    ".section .rodata\n"
    ".balign 16\n"
    "terrazzo_segment_judge:\n"
    ".incbin \"" TERRAZZO_SEGMENT_JUDGE
    "\"\n"
    "terrazzo_segment_judge_end:\n"
    ".previous\n");
extern "C" const char terrazzo_segment_judge[], terrazzo_segment_judge_end[];

namespace terrazzo::segment {

struct Judge::Model : ModelPool {
  using ModelPool::ModelPool;
};

Judge::Judge(std::string bytes)
    : model_(std::make_unique<Model>(std::move(bytes),
                                     "use an ONNX model with one input (n, 14) and one output (n, 1)")) {}
Judge::~Judge() = default;

std::vector<float> Judge::operator()(std::span<const Evidence> regions) const {
  constexpr int kTogether = 64;  // blobs of one shape share a copy of the model
  std::vector<float> scores;
  cv::Mat blob(kTogether, kEvidence, CV_32F);
  for (std::size_t first = 0; first < regions.size(); first += kTogether) {
    const auto part = regions.subspan(first, std::min<std::size_t>(kTogether, regions.size() - first));
    blob.setTo(0);
    std::memcpy(blob.data, part.data(), part.size_bytes());
    const cv::Mat out = model_->run(blob);
    if (out.total() != kTogether) model_->refuse("its output does not have one value per region");
    scores.insert(scores.end(), out.ptr<float>(), out.ptr<float>() + part.size());
  }
  return scores;
}

const Judge& built_in_judge() {
  static const Judge judge(std::string(terrazzo_segment_judge, terrazzo_segment_judge_end));
  return judge;
}

}  // namespace terrazzo::segment
