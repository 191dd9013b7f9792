#include "nodes/detail/detail_solid/phases.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/color_medians.h"
#include "nodes/common/texture/kmeans.h"
#include "nodes/data/detail.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/specks.h"

namespace terrazzo::detail_solid {
namespace {

constexpr std::size_t kLeastGroup = 1500;  // of a group's texture

// Marks pixels within `edge` of another label, in one section.
void exclude_outlines(const Labels& labels, int section, int edge, std::int8_t* phase) {
  if (edge <= 0) return;
  const auto depth =
      residual::outline_depth(&labels.ids[labels.index(0, 0, section)], labels.width, labels.height, false);
  for (std::size_t i = 0; i < depth.size(); ++i)
    if (depth[i] < edge + 0.49f) phase[i] = -1;
}

// Excludes particles missed by the labels and the binder's pixels beside them. Returns their fraction of the
// binder's pixels.
double exclude_specks(const Vec3f* encoded, double limit, int w, int h, std::int8_t* phase) {
  std::vector<std::uint8_t> binder(pixels_in(w, h));
  double all = 0;
  for (std::size_t i = 0; i < binder.size(); ++i) all += binder[i] = phase[i] == 0;
  const std::vector<std::size_t> far = residual::find_specks(encoded, binder, limit);
  for (const std::size_t i : far) {
    const int x = i % w, y = i / w;
    for (int b = std::max(0, y - 1); b <= std::min(h - 1, y + 1); ++b)
      for (int a = std::max(0, x - 1); a <= std::min(w - 1, x + 1); ++a) {
        std::int8_t& p = phase[static_cast<std::size_t>(b) * w + a];
        if (p == 0) p = -1;
      }
  }
  return all > 0 ? far.size() / all : 0;
}

// Groups of the profiles by color, from 1 by falling area. `color` is linear and `area` counts used pixels.
std::vector<int> group_profiles(const std::vector<Vec3f>& color, const std::vector<double>& area,
                                const PhaseOptions& choice, const Work& work) {
  std::vector<int> group(color.size(), 1);
  std::vector<Vec3> points;
  std::vector<double> weights;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < color.size(); ++i)
    if (area[i] > 0)
      points.push_back(linear_to_oklab(color[i]).cast<double>()), weights.push_back(area[i]),
          index.push_back(i);
  for (int k = std::min<int>(choice.groups, count_of(points)); k > 1; --k) {
    const ColorClusters clusters = kmeans(points, weights, k, choice.seed, work.quiet());
    std::vector<double> total(clusters.k, 0.0);
    for (std::size_t i = 0; i < points.size(); ++i) total[clusters.of[i]] += weights[i];
    if (*std::min_element(total.begin(), total.end()) < kLeastGroup) continue;
    for (std::size_t i = 0; i < points.size(); ++i) group[index[i]] = clusters.of[i] + 1;
    break;
  }
  return group;
}

}  // namespace

void check_photograph(const Image& image, const Labels& labels) {
  if (image.pixels.empty()) throw Error("empty-image", "the image has no pixels", "connect a photograph");
  require_equal_size(image, "the image has", labels, "the labels have", "use labels of the same photograph");
  for (const auto& p : image.pixels)
    if (!p.allFinite()) throw Error("bad-pixels", "the image contains NaN or infinity");
  for (const std::int32_t id : labels.ids)
    if (id < 0 || id > labels.count())
      throw Error("bad-labels",
                  fmt::format("the labels contain profile {}, but there are {}", id, labels.count()));
}

namespace {

// The encoded pixels of binder and particles, without those that do not count.
Phases encoded_pixels(const Image& image, const Labels& labels, const PhaseOptions& choice,
                      const Work& work) {
  Phases out;
  out.width = image.width;
  out.height = image.height;
  out.sections = image.sections;
  const std::size_t plane = out.plane(), pixels = image.pixels.size();
  out.offset.resize(pixels);
  out.phase.resize(pixels);
  work.quiet().parallel(pixels, 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      out.offset[i] = linear_to_srgb(image.pixels[i].cwiseMax(0.0f));
      out.phase[i] = choice.mask && choice.mask->ids[i] != 0 ? -1 : labels.ids[i] > 0;
    }
  });
  for (int s = 0; s < image.sections; ++s) {
    work.check();
    std::int8_t* phase = &out.phase[s * plane];
    exclude_outlines(labels, s, choice.edge, phase);
    if (choice.specks > 0)
      out.outliers += exclude_specks(&out.offset[s * plane], choice.specks, out.width, out.height, phase) /
                      image.sections;
  }
  return out;
}

// Draws one section in the colors of its particles that have pixels, and of its binder.
void draw_flat(const std::int32_t* ids, const std::vector<double>& area, const std::vector<Vec3f>& color,
               const Vec3f& binder, std::vector<Vec3f>& flat) {
  for (std::size_t k = 0; k < flat.size(); ++k)
    flat[k] = ids[k] > 0 && area[static_cast<std::size_t>(ids[k]) - 1] > 0
                  ? color[static_cast<std::size_t>(ids[k]) - 1]
                  : binder;
}

}  // namespace

Phases find_phases(const Image& image, const Labels& labels, const PhaseOptions& choice, const Work& work) {
  Phases out = encoded_pixels(image, labels, choice, work);
  const std::size_t plane = out.plane(), pixels = image.pixels.size();
  // Medians and means in linear light, as the flat colors of particles and binder are.
  std::vector<std::int64_t> used(labels.count(), 0);
  std::vector<Mean> binder(image.sections);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (out.phase[i] == 0) binder[i / plane].add(image.pixels[i]);
    if (out.phase[i] > 0) ++used[static_cast<std::size_t>(labels.ids[i]) - 1];
  }
  Vec3f moved = Vec3f::Zero();
  if (choice.binder) {
    Mean all;
    for (const Mean& m : binder) all.sum += m.sum, all.count += m.count;
    if (all.count > 0) moved = *choice.binder - all.value();
  }
  std::vector<Vec3f>& color = out.profile_color;
  std::vector<double> area(used.begin(), used.end());
  ColorMedians medians(std::move(used));
  for (std::size_t i = 0; i < pixels; ++i)
    if (out.phase[i] > 0) medians.add(static_cast<std::size_t>(labels.ids[i]) - 1, image.pixels[i]);
  for (std::size_t k = 0; k < area.size(); ++k) color.push_back(medians.value(k));
  const std::vector<int> group = group_profiles(color, area, choice, work);
  int groups = 0;
  for (std::size_t k = 0; k < group.size(); ++k)
    if (area[k] > 0) groups = std::max(groups, group[k]);
  std::vector<Mean> of_group(groups);
  out.pixels.assign(groups + 1, 0);
  std::vector<Vec3f> flat(plane);
  std::vector<float> scale;
  for (const Vec3f& c : color) scale.push_back(Detail::particle_scale(linear_to_srgb(c)));
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % plane == 0) {
      draw_flat(&labels.ids[i], area, color, binder[i / plane].value() + moved, flat);
      if (choice.softness > 0.2) {
        cv::Mat picture(out.height, out.width, CV_32FC3, flat.data());
        cv::GaussianBlur(picture, picture, {0, 0}, choice.softness);
      }
    }
    if (out.phase[i] < 0) {
      out.offset[i].setZero();
      continue;
    }
    out.offset[i] -= linear_to_srgb(flat[i % plane]);
    if (out.phase[i] > 0) {
      const auto k = static_cast<std::size_t>(labels.ids[i]) - 1;
      out.offset[i] /= scale[k];
      out.phase[i] = group[k];
      of_group[static_cast<std::size_t>(group[k]) - 1].add(color[k]);
    }
    ++out.pixels[out.phase[i]];
  }
  for (const Mean& m : of_group) out.group_color.push_back(m.value());
  return out;
}

residual::Outlines outlines_of(const Phases& p, const Labels& labels) {
  residual::Outlines all;
  for (int s = 0; s < p.sections; ++s) {
    const auto one = residual::nearest_outlines(&labels.ids[s * p.plane()], p.width, p.height, false);
    all.depth.insert(all.depth.end(), one.depth.begin(), one.depth.end());
    all.particle.insert(all.particle.end(), one.particle.begin(), one.particle.end());
    all.normal.insert(all.normal.end(), one.normal.begin(), one.normal.end());
  }
  return all;
}

}  // namespace terrazzo::detail_solid
