#include "nodes/residual_synth/synthesize.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/slice_family.h"
#include "nodes/residual_synth/start_field.h"

namespace terrazzo {

std::vector<Vec3f> synthesize_residual(const Exemplar& exemplar, const Vec3i& size, int rounds,
                                       std::uint64_t seed, SynthReport& report, const Work& work) {
  const std::size_t n = static_cast<std::size_t>(size.x()) * size.y() * size.z();
  std::vector<Vec3f> out(n, Vec3f::Zero());
  if (exemplar.channels == 0) return out;
  std::vector<SliceFamily> families;
  for (int axis = 0; axis < 3; ++axis) families.emplace_back(size, axis, exemplar.scales);
  SliceFamily::Workspace space;
  std::vector<float> sum(n);
  for (int c = 0; c < exemplar.channels; ++c) {
    const Work channel = work.part(double(c) / exemplar.channels, double(c + 1) / exemplar.channels);
    const Work quiet = channel.part(0, 0);
    const auto& bands = exemplar.bands[c];
    std::vector<float> volume =
        start_field(fit_power(bands, exemplar.scales), size, exemplar.scales, seed, 0x5e + c, quiet);
    match_values(volume, exemplar.values[c], quiet);
    for (int round = 0; round < rounds; ++round) {
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (int axis = 0; axis < 3; ++axis) {
        const double at = (round * 3 + axis) / (3.0 * rounds);
        families[axis].match(volume, bands, 1.0f / 3, sum, space, channel.part(at, at + 1 / (3.0 * rounds)));
      }
      volume.swap(sum);
      match_values(volume, exemplar.values[c], quiet);
    }
    if (c == 0)
      for (const SliceFamily& family : families) {
        const auto deviations = family.deviations(volume, bands, space, quiet);
        for (std::size_t b = 0; b < bands.size(); ++b) {
          const std::size_t scale = static_cast<std::size_t>(family.bands()[b].scale);
          if (report.deviation.size() <= scale) report.deviation.resize(scale + 1, 1.0);
          double& worst = report.deviation[scale];
          if (std::abs(deviations[b] - 1) > std::abs(worst - 1)) worst = deviations[b];
        }
      }
    double mean = 0;
    for (const float v : volume) mean += v;
    mean /= static_cast<double>(n);
    const Vec3f axis = exemplar.axes.col(c).cast<float>();
    for (std::size_t i = 0; i < n; ++i) out[i] += (volume[i] - static_cast<float>(mean)) * axis;
  }
  return out;
}

}  // namespace terrazzo
