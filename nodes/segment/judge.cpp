#include "nodes/segment/judge.h"

#include "nodes/segment/model_pool.h"

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
  if (regions.empty()) return {};
  const auto count = static_cast<int>(regions.size());
  const cv::Mat blob(count, kEvidence, CV_32F, const_cast<float*>(regions.front().data()));
  const cv::Mat out = model_->run(blob);
  if (static_cast<int>(out.total()) != count) model_->refuse("its output does not have one value per region");
  return {out.ptr<float>(), out.ptr<float>() + count};
}

const Judge& built_in_judge() {
  static const Judge judge(std::string(terrazzo_segment_judge, terrazzo_segment_judge_end));
  return judge;
}

}  // namespace terrazzo::segment
