#include "nodes/detail/residual/sheet_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/grid/floor_of.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

constexpr std::uint64_t kDiskStream = 0x73686574;
constexpr double kMostSheets = 1e6;
constexpr float kDiskFar = 3;                                 // standard deviations across
constexpr float kLongHeight = 0.8f, kShortHeight = 0.6f;      // heights of the waves; their squares sum to 1
constexpr float kLongWave = 1 / 1.3f, kShortWave = 1 / 2.7f;  // their lengths in diameters
constexpr float kDiskSqrt2 = std::numbers::sqrt2_v<float>;

}  // namespace

SheetField::SheetField(const Vec3& period, const Detail::Sheets& sheets, float most, double footprint,
                       std::uint64_t seed)
    : period_(period.cast<float>()) {
  if (!(sheets.density > 0)) return;
  constexpr double kPi = std::numbers::pi;
  const double diameter = std::min(4 / kPi * sheets.length, 0.5 * period.minCoeff());
  radius_ = static_cast<float>(diameter / 2);
  const double thin = kPi / 4 * sheets.width, wide = std::max(0.0, footprint * footprint - 1) / 12;
  width_ = static_cast<float>(std::sqrt(thin * thin + wide));
  share_ = static_cast<float>(thin / width_);
  bend_ = sheets.bend;
  const double area = 4 / kPi * sheets.density * most;  // per volume
  const double count = area / (kPi / 4 * diameter * diameter) * period.prod();
  Random random(seed, kDiskStream);
  const int n = round_down(std::min(count, kMostSheets) + random.uniform());
  std::vector<std::pair<std::size_t, Sheet>> all;
  const double reach = diameter / 2 + 1 + kDiskFar * (width_ + bend_);
  for (int a = 0; a < 3; ++a) cells_[a] = std::max(1, round_down(period[a] / reach));
  for (int i = 0; i < n; ++i) {
    Sheet s;
    Vec3i cell;
    for (int a = 0; a < 3; ++a) {
      const double at = random.uniform();
      s.center[a] = static_cast<float>(at) * period_[a];
      cell[a] = std::min(round_down(at * cells_[a]), cells_[a] - 1);
      s.normal[a] = static_cast<float>(random.normal());
    }
    s.normal.normalize();
    s.along = s.normal.unitOrthogonal();
    const auto turn = static_cast<float>(random.uniform(0, 2 * kPi));
    s.along = std::cos(turn) * s.along + std::sin(turn) * s.normal.cross(s.along);
    s.across = s.normal.cross(s.along);
    s.rank = most * static_cast<float>(random.uniform());
    for (float& wave : s.waves) wave = static_cast<float>(random.uniform(0, 2 * kPi));
    all.emplace_back(voxel_at(cell.x(), cell.y(), cell.z(), cells_), s);
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  first_.assign(voxels_in(cells_) + 1, 0);
  for (const auto& [cell, sheet] : all) {
    ++first_[cell + 1];
    sheets_.push_back(sheet);
  }
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
}

float SheetField::strength(const Sheet& s, Vec3f offset) const {
  for (int a = 0; a < 3; ++a)
    offset[a] -= period_[a] * static_cast<float>(floor_of(offset[a] / period_[a] + 0.5f));
  const float height = s.normal.dot(offset), far = kDiskFar * width_;
  if (std::abs(height) > 2 * bend_ + far) return 0;
  const float inside = radius_ - std::sqrt(std::max(0.0f, offset.squaredNorm() - height * height));
  if (inside <= -0.5f) return 0;  // the edge is a pixel wide
  constexpr float kTurn = 2 * std::numbers::pi_v<float>;
  const float per = kTurn / (2 * radius_);
  const float wave = kLongHeight * std::sin(per / kLongWave * s.along.dot(offset) + s.waves[0]) +
                     kShortHeight * std::sin(per / kShortWave * s.across.dot(offset) + s.waves[1]);
  const float d = (height - kDiskSqrt2 * bend_ * wave) / width_;
  return std::abs(d) < kDiskFar ? share_ * std::min(1.0f, inside + 0.5f) * std::exp(-0.5f * d * d) : 0;
}

float SheetField::at(const Vec3f& point, float relative) const {
  int near[3][3], nears[3];  // cells around the point's along each axis, without repetition
  for (int a = 0; a < 3; ++a) {
    const int home = floor_of(point[a] / period_[a] * static_cast<float>(cells_[a]));
    nears[a] = std::min(cells_[a], 3);
    for (int k = 0; k < nears[a]; ++k) near[a][k] = wrap_index(home + k - 1, cells_[a]);
  }
  float most = 0;
  for (int z = 0; z < nears[2]; ++z)
    for (int y = 0; y < nears[1]; ++y)
      for (int x = 0; x < nears[0]; ++x) {
        const std::size_t cell = voxel_at(near[0][x], near[1][y], near[2][z], cells_);
        for (std::size_t i = first_[cell]; i < first_[cell + 1]; ++i)
          if (sheets_[i].rank < relative)
            most = std::max(most, strength(sheets_[i], point - sheets_[i].center));
      }
  return most;
}

}  // namespace terrazzo::residual
