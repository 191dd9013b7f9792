#include "nodes/residual_synth/synthesize.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/slice_family.h"
#include "nodes/residual_synth/start_field.h"

namespace terrazzo {
namespace {

// Bands this near to the picture's are left as they are.
constexpr double kNear = 0.04;

}  // namespace

std::vector<Vec3f> synthesize_residual(const Exemplar& exemplar, const Vec3i& size, int rounds,
                                       std::uint64_t seed, const Work& work) {
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
    std::vector<float> volume = start_field(
        fit_power({&exemplar.wanted(0, c), &exemplar.wanted(1, c), &exemplar.wanted(2, c)}, exemplar.scales),
        size, exemplar.scales, seed, 0x5e + c, quiet);
    match_values(volume, exemplar.values[c], quiet);
    std::array<std::vector<float>, 3> drive;
    for (int round = 0; round < rounds; ++round) {
      std::fill(sum.begin(), sum.end(), 0.0f);
      double furthest = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double at = (round * 3 + axis) / (3.0 * rounds);
        furthest = std::max(
            furthest, families[axis].match(volume, exemplar.wanted(axis, c), 1.0f / 3, sum, space,
                                           channel.part(at, at + 1 / (3.0 * rounds)), 1 << 20, &drive[axis]));
      }
      if (furthest < kNear) break;  // of the volume as it was before this round
      volume.swap(sum);
      match_values(volume, exemplar.values[c], quiet);
    }
    double mean = 0;
    for (const float v : volume) mean += v;
    mean /= static_cast<double>(n);
    const Vec3f axis = exemplar.axes.col(c).cast<float>();
    for (std::size_t i = 0; i < n; ++i) out[i] += (volume[i] - static_cast<float>(mean)) * axis;
  }
  return out;
}

std::vector<double> slice_deviations(const Exemplar& exemplar, const Vec3i& size,
                                     const std::vector<Vec3f>& voxels, const Work& work) {
  std::vector<double> worst(static_cast<std::size_t>(exemplar.scales) + 2, 1.0);
  SliceFamily::Workspace space;
  std::vector<float> channel(voxels.size());
  for (int c = 0; c < exemplar.channels; ++c) {
    const Vec3f colour_axis = exemplar.axes.col(c).cast<float>();
    for (std::size_t i = 0; i < voxels.size(); ++i) channel[i] = colour_axis.dot(voxels[i]);
    for (int axis = 0; axis < 3; ++axis) {
      const SliceFamily family(size, axis, exemplar.scales);
      const auto deviations = family.deviations(channel, exemplar.wanted(axis, c), space, work.part(0, 0));
      for (std::size_t b = 0; b < deviations.size(); ++b) {
        double& w = worst[static_cast<std::size_t>(family.bands()[b].scale)];
        if (std::abs(deviations[b] - 1) > std::abs(w - 1)) w = deviations[b];
      }
    }
  }
  return worst;
}

}  // namespace terrazzo
