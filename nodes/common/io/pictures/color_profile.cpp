#include "nodes/common/io/pictures/color_profile.h"

#include <fmt/format.h>
#include <lcms2.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

namespace terrazzo {
namespace {

struct CloseProfile {
  void operator()(void* profile) const { cmsCloseProfile(profile); }
};
using OpenProfile = std::unique_ptr<void, CloseProfile>;

struct FreeCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};

// Little CMS's parametric curves; 4: (a·x + b)^γ from d on, c·x below.
OpenProfile rgb_profile(const Chromaticities& c, int kind, const std::vector<double>& parameters) {
  const std::unique_ptr<cmsToneCurve, FreeCurve> curve(
      cmsBuildParametricToneCurve(nullptr, kind, parameters.data()));
  cmsToneCurve* const curves[3] = {curve.get(), curve.get(), curve.get()};
  const cmsCIExyY white = {c.white[0], c.white[1], 1};
  const cmsCIExyYTRIPLE primaries = {
      {c.red[0], c.red[1], 1}, {c.green[0], c.green[1], 1}, {c.blue[0], c.blue[1], 1}};
  return OpenProfile(curve ? cmsCreateRGBProfile(&white, &primaries, curves) : nullptr);
}

OpenProfile stated_profile(const StatedColors& s) {
  switch (s.transfer) {
    case Transfer::Srgb:
      return rgb_profile(s.chromaticities, 4, {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045});
    case Transfer::Rec709:
      return rgb_profile(s.chromaticities, 4, {1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081});
    case Transfer::Power:
      break;
  }
  return rgb_profile(s.chromaticities, 1, {s.exponent});
}

Error bad_profile(const std::string& what) {
  return Error("bad-color-profile", what, "set colorspace to the color space of the picture, such as sRGB")
      .parameter("colorspace");
}

}  // namespace

struct ColorProfile::Transform {
  bool gray = false;
  cmsHTRANSFORM handle = nullptr;

  explicit Transform(const OpenProfile& profile) {
    const auto space = cmsGetColorSpace(profile.get());
    gray = space == cmsSigGrayData;
    if (!gray && space != cmsSigRgbData)
      throw bad_profile("the color profile is neither for RGB nor for gray");
    const OpenProfile linear = rgb_profile({}, 1, {1.0});
    handle =
        cmsCreateTransform(profile.get(), gray ? TYPE_GRAY_FLT : TYPE_RGB_FLT, linear.get(), TYPE_RGB_FLT,
                           INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE);
    if (!handle) throw bad_profile("the color profile does not say how to convert its colors");
  }
  Transform(const Transform&) = delete;
  Transform& operator=(const Transform&) = delete;
  ~Transform() { cmsDeleteTransform(handle); }
};

ColorProfile::ColorProfile(const std::string& icc) {
  const OpenProfile profile(cmsOpenProfileFromMem(icc.data(), static_cast<cmsUInt32Number>(icc.size())));
  if (!profile) throw bad_profile("the embedded color profile is damaged");
  transform_ = std::make_shared<const Transform>(profile);
  judge();
}

ColorProfile::ColorProfile(const StatedColors& s) {
  const OpenProfile profile = stated_profile(s);
  if (!profile) throw bad_profile(s.source + " span no colors");
  transform_ = std::make_shared<const Transform>(profile);
  judge();
}

bool ColorProfile::is_gray() const { return transform_->gray; }

void ColorProfile::to_linear(Vec3f* pixels, std::size_t count) const {
  constexpr std::size_t kBlock = 1 << 16;
  std::vector<float> gray;
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t n = std::min(kBlock, count - first);
    Vec3f* to = pixels + first;
    if (transform_->gray) {
      gray.resize(n);
      for (std::size_t i = 0; i < n; ++i) gray[i] = to[i].x();
    }
    const void* from = transform_->gray ? static_cast<const void*>(gray.data()) : to;
    cmsDoTransform(transform_->handle, from, to, static_cast<cmsUInt32Number>(n));
  }
}

void ColorProfile::judge() {
  constexpr int kSteps = 8;
  std::vector<Vec3f> encoded;
  for (int i = 0; i < (kSteps + 1) * (kSteps + 1) * (kSteps + 1); ++i) {
    const int r = i % (kSteps + 1), g = i / (kSteps + 1) % (kSteps + 1), b = i / (kSteps + 1) / (kSteps + 1);
    if (!transform_->gray || (r == g && g == b))
      encoded.push_back(Vec3f(float(r), float(g), float(b)) / kSteps);
  }
  std::vector<Vec3f> linear = encoded;
  to_linear(linear.data(), linear.size());
  for (const Vec3f& v : linear)
    if (!v.allFinite()) throw bad_profile("the color profile leads to infinite colors");
  double from_srgb = 0, from_linear = 0;
  for (std::size_t i = 0; i < encoded.size(); ++i) {
    const Vec3f shown = linear_to_srgb(linear[i].cwiseMax(0.0f).cwiseMin(1.0f));
    from_srgb = std::max(from_srgb, double((shown - encoded[i]).cwiseAbs().maxCoeff()));
    from_linear = std::max(from_linear, double((linear[i] - encoded[i]).cwiseAbs().maxCoeff()));
  }
  constexpr double kLevel = 1.0 / 255;
  is_srgb_ = from_srgb < kLevel / 2;
  is_linear_ = from_linear < kLevel / 20;
}

}  // namespace terrazzo
