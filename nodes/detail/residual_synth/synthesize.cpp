#include "nodes/detail/residual_synth/synthesize.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/texture/slice_family.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual_synth/start_field.h"

namespace terrazzo::residual_synth {
namespace {

constexpr double kNear = 0.035;  // accepted relative deviation of a band from the picture's
constexpr int kSweeps = 12;      // two or three suffice, except for sizes with few coefficients

// One color axis.
class Channel {
 public:
  Channel(const Exemplar& exemplar, int channel, const std::vector<SliceFamily>& families,
          SliceFamily::Workspace& space)
      : exemplar_(exemplar), channel_(channel), families_(families), space_(space) {}

  std::vector<float> start(const Vec3i& size, std::uint64_t seed, const Work& work) const {
    return start_field(fit_power({&wanted(0), &wanted(1), &wanted(2)}, exemplar_.scales), size, families_,
                       space_, seed, 0x5e + static_cast<std::uint64_t>(channel_), work);
  }

  // Matches the bands of all slices to the picture's distributions. The changes of the three axes are added
  // up; averaging them would need more than twice the rounds.
  void match(std::vector<float>& volume, std::vector<float>& sum, const Work& work) const {
    work.parallel(volume.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) sum[i] = -2 * volume[i];
    });
    for (int axis = 0; axis < 3; ++axis)
      families_[axis].match(volume, wanted(axis), 1, sum, space_, work.part(axis / 3.0, (axis + 1) / 3.0));
    volume.swap(sum);
  }

  // Brings the bands' deviations near the picture's in at most `sweeps` filters of the slices across each
  // axis, and matches the voxels to the picture's values. If value matching changes a band, the next sweep's
  // aim compensates.
  void balance(std::vector<float>& volume, int sweeps, const Work& work) const {
    std::array<std::vector<double>, 3> aim;
    for (int axis = 0; axis < 3; ++axis) aim[axis].assign(wanted(axis).size(), 1.0);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      double furthest = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const auto now = families_[axis].deviations(volume, wanted(axis), space_, work);
        for (std::size_t b = 0; b < now.size(); ++b) {
          furthest = std::max(furthest, std::abs(now[b] - 1));
          if (sweep > 0) aim[axis][b] = std::clamp(aim[axis][b] / std::max(now[b], 0.1), 0.25, 4.0);
        }
      }
      if (furthest < kNear) return;
      for (int axis = 0; axis < 3; ++axis)
        families_[axis].balance(volume, wanted(axis), aim[axis], space_, work);
      match_values(volume, exemplar_.values[channel_], work);
    }
  }

 private:
  const std::vector<Quantiles>& wanted(int axis) const { return exemplar_.wanted(axis, channel_); }

  const Exemplar& exemplar_;
  int channel_;
  const std::vector<SliceFamily>& families_;
  SliceFamily::Workspace& space_;
};

}  // namespace

std::vector<Vec3f> synthesize_residual(const Exemplar& exemplar, const Vec3i& size, int rounds,
                                       std::uint64_t seed, const Work& work) {
  const std::size_t n = voxels_in(size);
  std::vector<Vec3f> out(n, Vec3f::Zero());
  if (exemplar.channels == 0) return out;
  std::vector<SliceFamily> families;
  for (int axis = 0; axis < 3; ++axis) families.emplace_back(size, axis, exemplar.scales);
  SliceFamily::Workspace space;
  std::vector<float> sum(n);
  for (int c = 0; c < exemplar.channels; ++c) {
    const Work part = work.part(double(c) / exemplar.channels, double(c + 1) / exemplar.channels);
    const Work quiet = part.quiet();
    const Channel channel(exemplar, c, families, space);
    std::vector<float> volume = channel.start(size, seed, quiet);
    for (int round = 0; round < rounds; ++round) {
      channel.match(volume, sum, part.part(double(round) / rounds, (round + 1.0) / rounds));
      channel.balance(volume, round + 1 < rounds ? 1 : kSweeps, quiet);
    }
    if (rounds == 0) match_values(volume, exemplar.values[c], quiet);
    double mean = 0;
    for (const float v : volume) mean += v;
    mean /= n;
    const Vec3f axis = exemplar.axes.col(c).cast<float>();
    quiet.parallel(n, 1 << 15, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) out[i] += (volume[i] - static_cast<float>(mean)) * axis;
    });
  }
  return out;
}

std::vector<double> slice_deviations(const Exemplar& exemplar, const Vec3i& size,
                                     const std::vector<Vec3f>& voxels, const Work& work) {
  std::vector<double> worst(static_cast<std::size_t>(exemplar.scales) + 2, 1.0);
  SliceFamily::Workspace space;
  std::vector<float> channel(voxels.size());
  for (int c = 0; c < exemplar.channels; ++c) {
    const Vec3f color_axis = exemplar.axes.col(c).cast<float>();
    work.quiet().parallel(voxels.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) channel[i] = color_axis.dot(voxels[i]);
    });
    for (int axis = 0; axis < 3; ++axis) {
      const SliceFamily family(size, axis, exemplar.scales);
      const auto deviations = family.deviations(channel, exemplar.wanted(axis, c), space, work.quiet());
      for (std::size_t b = 0; b < deviations.size(); ++b) {
        double& w = worst[family.bands()[b].scale];
        if (std::abs(deviations[b] - 1) > std::abs(w - 1)) w = deviations[b];
      }
    }
  }
  return worst;
}

}  // namespace terrazzo::residual_synth
