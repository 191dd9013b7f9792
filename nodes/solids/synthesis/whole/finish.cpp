#include "nodes/solids/synthesis/whole/finish.h"

#include <algorithm>

#include "nodes/common/texture/band_statistics.h"
#include "nodes/common/texture/slice_family.h"
#include "nodes/common/texture/steerable_pyramid.h"

namespace terrazzo::solids {

void finish_bands(const std::vector<SolidExemplar>& working, const SolidOptions& s, SolidField& field,
                  const Work& work) {
  constexpr int kScales = 3, kLastScale = 2;
  std::vector<BandStatistics> wanted(working.size());
  for (std::size_t e = 0; e < working.size(); ++e) {
    Image picture(working[e].width, working[e].height, 1, 1);
    picture.pixels = working[e].pixels;
    wanted[e] = measure_bands(picture, field.channel.size(), kScales, work.quiet());
  }
  std::vector<int> axes;
  for (int a = 0; a < 3; ++a)
    if (s.plane[a] >= 0) axes.push_back(a);
  SliceFamily::Workspace space;
  std::vector<float> sum(field.channel[0].size());
  const std::size_t channels = field.channel.size();
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<const Quantiles*> values;
    for (int a : axes) values.push_back(&wanted[s.plane[a]].values[c]);
    const Quantiles target = mixture(values);
    for (int round = 0; round < s.finish; ++round) {
      const float planes = axes.size(), share = finish_share(axes.size());
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = (1 - share * planes) * field.channel[c][i];
      for (int a : axes) {
        const SliceFamily family(field.size, a, kScales);
        family.match(field.channel[c], wanted[s.plane[a]].bands[c], share, sum, space, work.quiet(),
                     kLastScale);
      }
      field.channel[c].swap(sum);
      match_values(field.channel[c], target, work.quiet());
      work.progress((c + (round + 1.0) / s.finish) / channels);
    }
  }
}

}  // namespace terrazzo::solids
