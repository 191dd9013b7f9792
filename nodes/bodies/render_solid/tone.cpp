#include "nodes/bodies/render_solid/tone.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/color_config.h"

namespace ocio = OCIO_NAMESPACE;

namespace terrazzo::render_solid {
namespace {

constexpr float kKnee = 0.85f;

// A table of the neutral curve. The knee is one of its nodes, so below it the table is exact.
ocio::TransformRcPtr neutral() {
  constexpr unsigned long kNodes = 41;
  constexpr double kTop = 2;
  auto range = ocio::RangeTransform::Create();
  range->setMinInValue(0);
  range->setMinOutValue(0);
  range->setMaxInValue(kTop);
  range->setMaxOutValue(1);
  auto table = ocio::Lut3DTransform::Create(kNodes);
  table->setInterpolation(ocio::INTERP_TETRAHEDRAL);
  const auto value = [](unsigned long i) { return static_cast<float>(kTop * double(i) / (kNodes - 1)); };
  for (unsigned long r = 0; r < kNodes; ++r)
    for (unsigned long g = 0; g < kNodes; ++g)
      for (unsigned long b = 0; b < kNodes; ++b) {
        const Vec3f v = neutral_curve(Vec3f(value(r), value(g), value(b)));
        table->setValue(r, g, b, v.x(), v.y(), v.z());
      }
  auto all = ocio::GroupTransform::Create();
  all->appendTransform(range);
  all->appendTransform(table);
  return all;
}

ocio::TransformRcPtr aces() {
  constexpr double kExposure = 1.6;
  const auto builtin = [](const char* style, ocio::TransformDirection direction) {
    auto t = ocio::BuiltinTransform::Create();
    t->setStyle(style);
    t->setDirection(direction);
    return t;
  };
  // Rec. 709 to and from the XYZ of its own white, D65 (IEC 61966-2-1).
  const double to_xyz[16] = {0.4123907993,
                             0.3575843394,
                             0.1804807884,
                             0,
                             0.2126390059,
                             0.7151686788,
                             0.0721923154,
                             0,
                             0.0193308187,
                             0.1191947798,
                             0.9505321522,
                             0,
                             0,
                             0,
                             0,
                             1};
  const auto matrix = [&](ocio::TransformDirection direction) {
    auto t = ocio::MatrixTransform::Create();
    t->setMatrix(to_xyz);
    t->setDirection(direction);
    return t;
  };
  const double gain[16] = {kExposure, 0, 0, 0, 0, kExposure, 0, 0, 0, 0, kExposure, 0, 0, 0, 0, 1};
  auto exposed = ocio::MatrixTransform::Create();
  exposed->setMatrix(gain);
  auto positive = ocio::RangeTransform::Create();
  positive->setMinInValue(0);
  positive->setMinOutValue(0);
  auto all = ocio::GroupTransform::Create();
  all->appendTransform(exposed);
  all->appendTransform(positive);
  all->appendTransform(matrix(ocio::TRANSFORM_DIR_FORWARD));
  all->appendTransform(builtin("UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD", ocio::TRANSFORM_DIR_INVERSE));
  all->appendTransform(
      builtin("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0", ocio::TRANSFORM_DIR_FORWARD));
  all->appendTransform(matrix(ocio::TRANSFORM_DIR_INVERSE));
  return all;
}

}  // namespace

struct Tone::Transform {
  ocio::ConstCPUProcessorRcPtr processor;
};

Tone::Tone(ToneKind kind, const std::string& view) : view_(kind == ToneKind::View), name_(view) {
  if (view_) {
    show_through_view(nullptr, 0, 0, view);  // fail now, not after rendering
    return;
  }
  if (kind == ToneKind::None) return;
  try {
    transform_ = std::make_unique<Transform>();
    transform_->processor = ocio::Config::CreateRaw()
                                ->getProcessor(kind == ToneKind::Aces ? aces() : neutral())
                                ->getDefaultCPUProcessor();
  } catch (const ocio::Exception& e) {
    throw Error("color-config", std::string("the OpenColorIO display rendering failed: ") + e.what(),
                "set tone: none")
        .parameter("tone");
  }
}

Tone::~Tone() = default;

void Tone::apply(Image& image) const {
  const long rows = static_cast<long>(image.height) * image.sections;
  if (image.pixels.empty() || (!view_ && !transform_)) return;
  if (view_) {
    show_through_view(image.pixels.data(), image.width, rows, name_);
    return;
  }
  ocio::PackedImageDesc pixels(image.pixels.data()->data(), image.width, rows, 3);
  transform_->processor->apply(pixels);
  for (Vec3f& p : image.pixels) p = p.cwiseMax(0.0f).cwiseMin(1.0f);
}

Vec3f neutral_curve(const Vec3f& linear) {
  const Vec3f v = linear.cwiseMax(0.0f);
  const float m = v.maxCoeff();
  if (m <= kKnee) return v;
  return v * ((kKnee + (1 - kKnee) * (1 - std::exp(-(m - kKnee) / (1 - kKnee)))) / m);
}

}  // namespace terrazzo::render_solid
