// Statistics of the sections of shapes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "nodes/common/stereology/outline_features.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"

namespace terrazzo::shape_metrics {

// Curvature bins from −4 to 8, 0.25 wide, in units of the curvature of a circle of equal length. The end
// bins include values beyond.
inline constexpr int kCurvatureBins = 48;
inline constexpr double kCurvatureFrom = -4;
inline constexpr double kCurvatureStep = 0.25;

// Statistics over all profiles of the sections of one kind; disjoint profiles of a
// section are counted separately.
struct SectionSummary {
  std::size_t profiles = 0;
  std::array<double, kOutlineFeatures> mean{}, sd{};
  std::array<double, kCurvatureBins> curvature{};  // share of the length of the outlines
};

struct MetricsOptions {
  std::size_t sections = 10000;  // number of each kind
  std::uint64_t seed = 1;
  OutlineMeasuring measuring;
};

// Throws Error "no-profile" if no section has an area.
SectionSummary summarize(const Shapes&, SectionKind, const MetricsOptions&, const Work& = {});

struct MetricsRow {
  std::string name;
  SectionSummary central, random;
};

// Columns: name, sections ("central", "random"), profiles, then for each measure its mean, its standard
// deviation, and the deviation of the mean from that of the first row of the same kind, %.
Table table_of(const std::vector<MetricsRow>&);
// Figure 13 of Jagnow et al. 2008: means and standard deviations of total curvature and area/perimeter²,
// central above random; below them the distribution of curvature.
Image figure_of(const std::vector<MetricsRow>&);

}  // namespace terrazzo::shape_metrics
