#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "tests/bench/blobs.h"
#include "tests/bench/gpu/measure.h"

namespace terrazzo::gpu {
namespace {
namespace so = solids;

// Attributes the seconds between reports to the stage that the last note named.
class Stages {
 public:
  Work work() const { return Work(nullptr, &report_); }
  std::map<std::string, double> seconds() {
    enter("");
    return seconds_;
  }

 private:
  void enter(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    seconds_[stage_] += std::chrono::duration<double>(now - since_).count();
    stage_ = stage;
    since_ = now;
  }
  std::map<std::string, double> seconds_;
  std::string stage_ = "start";
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
  Work::Report report_ = [this](double, const std::string& note) {
    if (!note.empty() && note != stage_) enter(note);
  };
};

struct Made {
  so::SolidResult solid;
  double seconds;
  std::map<std::string, double> stages;
};

Made make(const so::SolidExemplar& e, const so::SolidOptions& s, so::BlockGl* gl) {
  Made m;
  Stages stages;
  m.seconds = seconds_of([&] { m.solid = so::optimize_solid({e}, s, stages.work(), gl); });
  m.stages = stages.seconds();
  return m;
}

// Share of voxels that differ by more than a thousandth of the exemplar's standard deviation, and the largest
// difference.
std::pair<double, double> difference(const so::SolidField& a, const so::SolidField& b) {
  std::size_t count = 0;
  double largest = 0;
  for (std::size_t i = 0; i < a.channel[0].size(); ++i) {
    float most = 0;
    for (std::size_t c = 0; c < a.channel.size(); ++c)
      most = std::max(most, std::abs(a.channel[c][i] - b.channel[c][i]));
    count += !(most <= 1e-3f);
    largest = std::max<double>(largest, most);
  }
  return {static_cast<double>(count) / static_cast<double>(a.channel[0].size()), largest};
}

std::string text_of(const std::map<std::string, double>& stages) {
  std::string text;
  for (const auto& [stage, seconds] : stages)
    if (seconds >= 0.005) text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", stage, seconds);
  return text;
}

void measure_solid(const Options& o, so::BlockGl& gl, int side, double whole, int parts, const Tell& tell) {
  if (side > o.most) return;
  const so::SolidExemplar exemplar = bench::blobs(o.quick ? 48 : 128);
  so::SolidOptions s;
  s.method = so::SolidMethod::Blockwise;
  s.size = Vec3i::Constant(side);
  s.blockwise_limits.whole = whole;
  s.blocks = Vec3i::Constant(parts);
  Made on_device;
  const double seconds = median(repeated(o, [&] { on_device = make(exemplar, s, &gl); }));
  const Made reference = make(exemplar, s, nullptr);
  const auto [share, largest] = difference(on_device.solid.field, reference.solid.field);
  tell(fmt::format("solid {}³{}, at most {:.0f}³ whole: {:.2f} s ({}); processor {:.2f} s ({}); {:.2g} % of "
                   "voxels differ, "
                   "largest {:.2g}",
                   side, parts > 1 ? fmt::format(", one of {}³ blocks", parts) : "", std::cbrt(whole),
                   seconds, text_of(on_device.stages), reference.seconds, text_of(reference.stages),
                   100 * share, largest),
       {{"kind", "solid"},
        {"edge", side},
        {"whole", whole},
        {"blocks", parts},
        {"seconds", seconds},
        {"stages", on_device.stages},
        {"processor_seconds", reference.seconds},
        {"processor_stages", reference.stages},
        {"differing_share", share},
        {"largest_difference", largest}});
}

}  // namespace

void measure_solids(const Options& o, const Tell& tell) {
  so::BlockGl gl(o.device);
  if (o.quick) return measure_solid(o, gl, 48, 1, 1, tell);
  const double standard = so::BlockwiseLimits().whole, least = 1;
  measure_solid(o, gl, 128, standard, 1, tell);
  measure_solid(o, gl, 128, least, 1, tell);
  measure_solid(o, gl, 256, standard, 1, tell);
  measure_solid(o, gl, 256, least, 1, tell);
  measure_solid(o, gl, 512, standard, 2, tell);
}

}  // namespace terrazzo::gpu
