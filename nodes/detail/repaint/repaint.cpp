#include "nodes/detail/repaint/repaint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "nodes/common/texture/color_medians.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/camera_noise.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/picture_detail.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/random.h"

namespace terrazzo::repaint {
namespace {

constexpr std::uint64_t kPlaneStream = 0x72657061;

struct FlatColors {
  std::vector<Vec3f> profile;  // of label k at k − 1
  Vec3f binder = Vec3f::Zero();
};

// Pixels beside outlines have mixed colors; they count only for profiles that have no others.
FlatColors flat_colors(const Vec3f* pixels, const std::int32_t* ids, std::size_t count,
                       const std::vector<float>& depth, std::int32_t labels) {
  constexpr float kClear = 1.5f;
  std::vector<std::int64_t> clear(labels, 0), all(labels, 0);
  Vec3 sum = Vec3::Zero(), mixed = Vec3::Zero();
  double binder = 0, beside = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (ids[i] > 0) continue;
    if (depth[i] > kClear) {
      sum += pixels[i].cast<double>();
      ++binder;
    } else {
      mixed += pixels[i].cast<double>();
      ++beside;
    }
  }
  if (binder == 0) {
    sum = mixed;
    binder = beside;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (ids[i] > 0) {
      ++all[ids[i] - 1];
      clear[ids[i] - 1] += depth[i] > kClear;
    }
  const auto counts = [&](std::size_t i) {
    return ids[i] > 0 && (depth[i] > kClear || clear[ids[i] - 1] == 0);
  };
  std::vector<std::int64_t> used = clear;
  for (std::size_t k = 0; k < used.size(); ++k)
    if (used[k] == 0) used[k] = all[k];
  ColorMedians medians(std::move(used));
  for (std::size_t i = 0; i < count; ++i)
    if (counts(i)) medians.add(ids[i] - 1, pixels[i]);
  FlatColors out;
  for (std::int32_t k = 0; k < labels; ++k) out.profile.push_back(medians.value(k));
  if (binder > 0) out.binder = (sum / binder).cast<float>();
  return out;
}

void check(const Image& photograph, const Labels& labels) {
  if (photograph.pixels.empty())
    throw Error("empty-image", "the image has no pixels", "connect a photograph");
  require_equal_size(photograph, "the image has", labels, "the labels have",
                     "use labels of the same photograph");
  for (const std::int32_t id : labels.ids)
    if (id < 0 || id > labels.count())
      throw Error("bad-labels",
                  fmt::format("the labels contain profile {}, but there are {}", id, labels.count()));
}

// The plane of a picture in the middle of a box.
struct PicturePlane {
  int width, height;
  double pixel;  // mm
  Quat turn;

  double side() const { return 2 * std::hypot(width, height) * pixel; }  // of the box
  Vec3 at(double x, double y) const {
    return Vec3::Constant(side() / 2) + turn * Vec3((x - width / 2.0) * pixel, (height / 2.0 - y) * pixel, 0);
  }
};

// A particle for each profile. `sizes`: by label.
Particles particles_of(std::span<const std::int32_t> ids, const std::vector<float>& sizes,
                       const FlatColors& flat, const PicturePlane& plane) {
  const std::size_t count = flat.profile.size();
  Particles particles;
  particles.box = Vec3::Constant(plane.side());
  particles.resize(count);
  std::vector<Vec3> sum(count, Vec3::Zero());
  std::vector<float> sizes_of(count, 0);
  for (std::size_t id = 1; id < sizes.size(); ++id) sizes_of[id - 1] = sizes[id];
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i] > 0) sum[ids[i] - 1] += Vec3((i % plane.width) + 0.5, (i / plane.width) + 0.5, 1);
  for (std::size_t k = 0; k < count; ++k) {
    const double n = std::max(1.0, sum[k].z());
    particles.position[k] = sum[k].z() > 0 ? plane.at(sum[k].x() / n, sum[k].y() / n) : plane.at(0, 0);
    // The field takes the mean profile of a particle for what is seen of it.
    particles.size[k] = std::max<double>(plane.pixel, sizes_of[k] / residual::kShownSize);
    particles.color[k] = flat.profile[k];
  }
  particles.binder_color = flat.binder;
  return particles;
}

}  // namespace

Image repaint(const Image& photograph, const Labels& labels, const Detail* detail, std::uint64_t seed,
              const Work& work) {
  check(photograph, labels);
  Image out = photograph;
  const int width = photograph.width, height = photograph.height;
  const std::size_t plane = pixels_in(width, height);
  const double pixel = photograph.pixel_size;
  for (int s = 0; s < photograph.sections; ++s) {
    const Work part = work.part(double(s) / photograph.sections, double(s + 1) / photograph.sections);
    const std::int32_t* ids = &labels.ids[labels.index(0, 0, s)];
    Vec3f* pixels = &out.pixels[out.index(0, 0, s)];
    const residual::Outlines outlines = residual::nearest_outlines(ids, width, height, false);
    const FlatColors flat = flat_colors(pixels, ids, plane, outlines.depth, labels.count());
    std::vector<float> cover(plane);
    for (std::size_t i = 0; i < plane; ++i) {
      cover[i] = ids[i] > 0;
      pixels[i] = ids[i] > 0 ? flat.profile[ids[i] - 1] : flat.binder;
    }
    part.check();
    if (!detail) continue;
    // Labels are whole pixels. This gives outlines about the partial pixels that exact ones would have.
    constexpr double kPartial = 0.35;
    const double sigma = std::hypot(detail->softness * detail->pixel_size / pixel, kPartial);
    cv::Mat picture(height, width, CV_32FC3, pixels), mask(height, width, CV_32F, cover.data());
    cv::GaussianBlur(picture, picture, {0, 0}, sigma, sigma, cv::BORDER_REPLICATE);
    cv::GaussianBlur(mask, mask, {0, 0}, sigma, sigma, cv::BORDER_REPLICATE);
    // Profiles become particles around a plane that no axis of the tiles lies in, so that it shows them as
    // sections of a solid do.
    const std::vector<float> sizes = residual::sizes_of_particles({ids, plane}, pixel);
    Random random(seed, kPlaneStream, static_cast<std::uint64_t>(s));
    Quat turn;
    for (int k = 0; k < 4; ++k) turn.coeffs()[k] = random.normal();
    turn.normalize();
    const PicturePlane place{width, height, pixel, turn};
    const Particles particles = particles_of({ids, plane}, sizes, flat, place);
    const residual::ResidualField field(*detail, particles, pixel, residual::Keep::Power, part.quiet());
    std::vector<std::int32_t> owner(plane, -1);
    for (std::size_t i = 0; i < plane; ++i)
      if (cover[i] > 0) owner[i] = (ids[i] > 0 ? ids[i] : outlines.particle[i]) - 1;
    residual::add_to_picture(
        pixels,
        {width, height, pixel, pixel, false, place.at(0, height), turn * Vec3::UnitX(), turn * Vec3::UnitY()},
        {ids, plane}, owner, cover, field, part);
    residual::add_noise(pixels, width, height, pixel, false, residual::camera_of(*detail, seed),
                        static_cast<std::uint64_t>(s), part);
  }
  return out;
}

}  // namespace terrazzo::repaint
