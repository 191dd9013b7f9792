#include "nodes/common/stereology/profile_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/fill_loops.h"
#include "nodes/common/stereology/outline_measures.h"

namespace terrazzo {

std::vector<ProfileColumn> profile_columns(const Profiles& profiles, const Work& work) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  static const struct {
    const char* name;
    int power;
    double OutlineMeasures::*value;
  } kMeasures[] = {
      {"perimeter", 1, &OutlineMeasures::perimeter},     {"major_axis", 1, &OutlineMeasures::major_axis},
      {"minor_axis", 1, &OutlineMeasures::minor_axis},   {"orientation", 0, &OutlineMeasures::orientation},
      {"feret_max", 1, &OutlineMeasures::feret_max},     {"feret_min", 1, &OutlineMeasures::feret_min},
      {"circularity", 0, &OutlineMeasures::circularity}, {"solidity", 0, &OutlineMeasures::solidity}};
  const std::size_t n = profiles.profiles.size();
  std::vector<ProfileColumn> out = {{"equivalent_diameter", 1, {}}};
  for (const Profile& p : profiles.profiles)
    out[0].values.push_back(std::sqrt(4 / std::numbers::pi * p.area));
  if (std::all_of(profiles.profiles.begin(), profiles.profiles.end(),
                  [](const Profile& p) { return p.contour.empty(); }))
    return out;
  for (const auto& m : kMeasures) out.push_back({m.name, m.power, std::vector<double>(n, kUnknown)});
  work.parallel(n, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (profiles.profiles[i].contour.empty()) continue;
      const OutlineMeasures measures = outline_measures(profiles.profiles[i].contour);
      for (std::size_t k = 0; k < std::size(kMeasures); ++k)
        out[k + 1].values[i] = measures.*kMeasures[k].value;
    }
  });
  return out;
}

std::vector<Vec3f> mean_colors(const Profiles& profiles, const Image& image, const Work& work) {
  require_picture(profiles, image.width, image.height, image.sections, image.pixel_size);
  std::vector<Vec3f> out(profiles.profiles.size());
  work.parallel(out.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Profile& p = profiles.profiles[i];
      Vec3 sum = Vec3::Zero();
      std::int64_t pixels = 0;
      fill_loops({in_pixels(p.contour, image.pixel_size, image.height)}, image.width, image.height,
                 [&](int y, int first, int last) {
                   for (int x = first; x < last; ++x) sum += image.at(x, y, p.section).cast<double>();
                   pixels += last - first;
                 });
      out[i] = (sum / static_cast<double>(pixels)).cast<float>();  // NaN without pixels
    }
  });
  return out;
}

void require_picture(const Profiles& profiles, int width, int height, int sections, double pixel_size) {
  const Vec2 size = pixel_size * Vec2(width, height);
  const bool known = profiles.window.minCoeff() > 0;
  if ((!known || (profiles.window - size).norm() < 1e-6 * size.norm()) && profiles.sections <= sections)
    return;
  throw Error(
      "size-mismatch",
      fmt::format("the profiles are of {} pictures of {:.6g} × {:.6g} mm, but the connected picture "
                  "has {} sections of {:.6g} × {:.6g} mm",
                  profiles.sections, profiles.window.x(), profiles.window.y(), sections, size.x(), size.y()),
      "connect the picture in which the profiles were measured");
}

Loop in_pixels(const std::vector<Vec2>& contour, double pixel_size, int height) {
  Loop out;
  for (auto p = contour.rbegin(); p != contour.rend(); ++p)
    out.emplace_back(p->x() / pixel_size, height - p->y() / pixel_size);
  return out;
}

}  // namespace terrazzo
