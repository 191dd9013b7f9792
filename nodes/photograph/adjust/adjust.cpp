#include "nodes/photograph/adjust/adjust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::adjust {
namespace {

Image cropped(const Image& image, const std::array<int, 4>& crop) {
  const auto [left, top, width, height] = crop;
  if (width > image.width - left || height > image.height - top)
    throw Error("bad-region",
                fmt::format("the crop of {} × {} pixels at {}, {} leaves the picture of {} × {} pixels",
                            width, height, left, top, image.width, image.height),
                "choose a part of the picture")
        .parameter("crop");
  Image out(width, height, image.sections, image.pixel_size);
  for (int section = 0; section < out.sections; ++section)
    for (int y = 0; y < height; ++y)
      std::copy_n(image.pixels.begin() + image.index(left, top + y, section), width,
                  out.pixels.begin() + out.index(0, y, section));
  out.georeference = image.georeference;
  if (out.georeference) {
    const Vec2 corner = out.georeference->on_map(Vec2(left, top));
    out.georeference->m[2] = corner.x();
    out.georeference->m[5] = corner.y();
  }
  return out;
}

// Maps an sRGB-encoded value. Above white, the curve continues as a straight line.
float level(float v, const AdjustOptions& o) {
  const double share = std::max((v - o.black) / (o.white - o.black), 0.0);
  return static_cast<float>(share < 1 ? std::pow(share, 1 / o.gamma) : 1 + (share - 1) / o.gamma);
}

// Filter Effects Module Level 1, feColorMatrix, hueRotate after saturate: both keep the luminance of Rec.
// 709.
Eigen::Matrix3f color_matrix(const AdjustOptions& o) {
  const double angle = o.hue * std::numbers::pi / 180;
  const Eigen::Matrix3d gray = Vec3::Ones() * Vec3(0.213, 0.715, 0.072).transpose();
  const Eigen::Matrix3d color = Eigen::Matrix3d::Identity() - gray;
  Eigen::Matrix3d turned;
  turned << -0.213, -0.715, 0.928, 0.143, 0.140, -0.283, -0.787, 0.715, 0.072;
  const Eigen::Matrix3d hue = gray + std::cos(angle) * color + std::sin(angle) * turned;
  return (hue * (gray + o.saturation * color)).cast<float>();
}

}  // namespace

Image adjust_image(const Image& image, const AdjustOptions& o, const Work& work) {
  if (image.pixels.empty()) throw Error("empty-image", "the image has no pixels", "connect an image");
  Image out = o.crop ? cropped(image, *o.crop) : image;
  const bool levels = o.black != 0 || o.white != 1 || o.gamma != 1, colors = o.hue != 0 || o.saturation != 1;
  if (!levels && !colors) return out;
  const Eigen::Matrix3f matrix = color_matrix(o);
  work.parallel(out.pixels.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3f& p = out.pixels[i];
      if (levels) p = srgb_to_linear(linear_to_srgb(p).unaryExpr([&](float v) { return level(v, o); }));
      if (colors) p = (matrix * p).cwiseMax(0.0f);
    }
  });
  return out;
}

}  // namespace terrazzo::adjust
