// Statistics of the sections of shapes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "nodes/common/outline_features.h"
#include "nodes/common/random_sections.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"

namespace terrazzo::shape_metrics {

inline constexpr int kCurvatureBins =
    48;  // of curvature, from −4 to 8 circles', 0.25 wide; ends take what is beyond
inline constexpr double kCurvatureFrom = -4, kCurvatureStep = 0.25;

// Of all profiles of the sections of one kind; disjoint profiles of a section count apart.
struct SectionSummary {
  std::size_t profiles = 0;
  std::array<double, kOutlineFeatures> mean{}, sd{};
  std::array<double, kCurvatureBins> curvature{};  // share of the outlines' length
};

struct MetricsChoice {
  std::size_t sections = 10000;  // of each kind
  std::uint64_t seed = 1;
  OutlineMeasuring measuring;
};

// Throws Error "no-profile" where every section is without area.
SectionSummary summarise(const Shapes&, SectionKind, const MetricsChoice&, const Work& = {});

struct MetricsRow {
  std::string name;
  SectionSummary central, random;
};

// Columns: name, sections ("central", "random"), profiles, then mean and sd of each measure, and how far each
// mean is from the first row's of the same kind, %.
Table table_of(const std::vector<MetricsRow>&);
// Figure 13 of Jagnow et al. 2008: means with standard deviations of total curvature and area/perimeter²,
// central above random; below them the distribution of curvature.
Image figure_of(const std::vector<MetricsRow>&);

}  // namespace terrazzo::shape_metrics
