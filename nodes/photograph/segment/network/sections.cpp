#include "nodes/photograph/segment/network/sections.h"

#include <algorithm>

namespace terrazzo::segment {
namespace {

constexpr std::size_t kMostPixelsKept = 16u << 20;

bool mostly_ignored(const Instance& in, const IgnoredPixels& ignored, std::size_t first) {
  if (ignored.empty()) return false;
  const auto n =
      std::count_if(in.pixels.begin(), in.pixels.end(), [&](auto i) { return ignored[first + i] != 0; });
  return 2 * n > static_cast<std::ptrdiff_t>(in.pixels.size());
}

}  // namespace

NetworkSections::NetworkSections(const Image& image, double scale, const Network& network,
                                 const NetworkOptions& candidates, const IgnoredPixels& ignored)
    : image_(image),
      scale_(scale),
      network_(network),
      options_(candidates),
      ignored_(ignored),
      keep_(image.pixels.size() <= kMostPixelsKept),
      views_(image.sections),
      candidates_(image.sections) {}

std::shared_ptr<const NetworkView> NetworkSections::view(int section, const Work& work) {
  if (views_[section]) return views_[section];
  auto view = std::make_shared<const NetworkView>(image_, section, scale_, network_, work);
  if (keep_) views_[section] = view;
  return view;
}

std::vector<Instance> NetworkSections::candidates(int section, const Work& work) {
  if (!candidates_[section].empty()) return candidates_[section];
  std::vector<Instance> all = view(section, work)->instances(options_, work.quiet());
  std::erase_if(
      all, [&](const Instance& in) { return mostly_ignored(in, ignored_, image_.index(0, 0, section)); });
  if (keep_) candidates_[section] = all;
  return all;
}

}  // namespace terrazzo::segment
