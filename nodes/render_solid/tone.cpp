#include "nodes/render_solid/tone.h"

#include <OpenColorIO/OpenColorIO.h>

#include "graph/diagnostic.h"

namespace ocio = OCIO_NAMESPACE;

namespace terrazzo {
namespace {

ocio::ConstCPUProcessorRcPtr processor() {
  const auto builtin = [](const char* style, ocio::TransformDirection direction) {
    auto t = ocio::BuiltinTransform::Create();
    t->setStyle(style), t->setDirection(direction);
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
    t->setMatrix(to_xyz), t->setDirection(direction);
    return t;
  };
  auto all = ocio::GroupTransform::Create();
  all->appendTransform(matrix(ocio::TRANSFORM_DIR_FORWARD));
  all->appendTransform(builtin("UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD", ocio::TRANSFORM_DIR_INVERSE));
  all->appendTransform(
      builtin("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0", ocio::TRANSFORM_DIR_FORWARD));
  all->appendTransform(matrix(ocio::TRANSFORM_DIR_INVERSE));
  return ocio::Config::CreateRaw()->getProcessor(all)->getDefaultCPUProcessor();
}

}  // namespace

void aces_tone(Image& image, float exposure) {
  if (image.pixels.empty()) return;
  for (Vec3f& p : image.pixels) p = (p * exposure).cwiseMax(0.0f);
  try {
    ocio::PackedImageDesc pixels(image.pixels.data()->data(), image.width,
                                 static_cast<long>(image.height) * image.sections, 3);
    processor()->apply(pixels);
  } catch (const ocio::Exception& e) {
    throw Error("color-config", std::string("OpenColorIO's rendering for displays failed: ") + e.what(),
                "set tone: neutral")
        .parameter("tone");
  }
  for (Vec3f& p : image.pixels) p = p.cwiseMax(0.0f).cwiseMin(1.0f);
}

}  // namespace terrazzo
