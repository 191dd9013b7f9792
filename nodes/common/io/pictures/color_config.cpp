#include "nodes/common/io/pictures/color_config.h"

#include <OpenColorIO/OpenColorIO.h>

#include <cstdlib>
#include <sstream>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

namespace ocio = OCIO_NAMESPACE;

namespace terrazzo {
namespace {

// Reference space: scene-linear Rec. 709. The matrices follow from the primaries of each standard,
// Bradford-adapted to D65.
constexpr const char* built_in_text = R"(ocio_profile_version: 2
name: terrazzo
roles: {default: raw, scene_linear: lin_rec709, aces_interchange: ACES2065-1, data: raw}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  sRGB:
    - !<View> {name: Raw, colorspace: raw}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: lin_rec709
    aliases: [linear, Linear Rec.709, Linear Rec.709 (sRGB), lin_rec709_scene, lin_srgb, Utility - Linear - sRGB]
    description: Scene-linear, Rec. 709 primaries, D65
  - !<ColorSpace>
    name: sRGB
    aliases: [srgb, sRGB - Texture, srgb_tx, srgb_texture, Utility - sRGB - Texture]
    description: IEC 61966-2-1
    to_reference: !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, style: mirror}
  - !<ColorSpace>
    name: Rec.709
    aliases: [rec709, camera_rec709, Camera Rec.709]
    description: ITU-R BT.709 camera encoding
    to_reference: !<ExponentWithLinearTransform> {gamma: 2.22222222222222, offset: 0.099, style: mirror}
  - !<ColorSpace>
    name: Gamma 1.8 Rec.709
    aliases: [g18_rec709]
    to_reference: !<ExponentTransform> {value: [1.8, 1.8, 1.8, 1], style: mirror}
  - !<ColorSpace>
    name: Gamma 2.2 Rec.709
    aliases: [g22_rec709]
    to_reference: !<ExponentTransform> {value: [2.2, 2.2, 2.2, 1], style: mirror}
  - !<ColorSpace>
    name: Gamma 2.4 Rec.709
    aliases: [g24_rec709]
    to_reference: !<ExponentTransform> {value: [2.4, 2.4, 2.4, 1], style: mirror}
  - !<ColorSpace>
    name: Linear P3-D65
    aliases: [lin_p3d65]
    to_reference: !<MatrixTransform> {matrix: [1.2249401763, -0.2249401763, 0, 0, -0.0420569547, 1.0420569547, 0, 0, -0.0196375546, -0.0786360456, 1.0982736001, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: Display P3
    aliases: [srgb_p3d65, p3d65_display]
    to_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, style: mirror}
        - !<MatrixTransform> {matrix: [1.2249401763, -0.2249401763, 0, 0, -0.0420569547, 1.0420569547, 0, 0, -0.0196375546, -0.0786360456, 1.0982736001, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: Adobe RGB
    aliases: [adobergb, AdobeRGB]
    to_reference: !<GroupTransform>
      children:
        - !<ExponentTransform> {value: [2.19921875, 2.19921875, 2.19921875, 1], style: mirror}
        - !<MatrixTransform> {matrix: [1.3983557440, -0.3983557440, 0, 0, 0, 1, 0, 0, 0, -0.0429289893, 1.0429289893, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: Linear Rec.2020
    aliases: [lin_rec2020]
    to_reference: !<MatrixTransform> {matrix: [1.6604910021, -0.5876411388, -0.0728498633, 0, -0.1245504745, 1.1328998971, -0.0083494226, 0, -0.0181507634, -0.1005788980, 1.1187296614, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: ACEScg
    aliases: [lin_ap1]
    to_reference: !<MatrixTransform> {matrix: [1.7050509927, -0.6217921207, -0.0832588720, 0, -0.1302564175, 1.1408047366, -0.0105483191, 0, -0.0240033568, -0.1289689761, 1.1529723329, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: ACES2065-1
    aliases: [lin_ap0]
    to_reference: !<MatrixTransform> {matrix: [2.5216861867, -1.1341309882, -0.3875551985, 0, -0.2764799142, 1.3727190877, -0.0962391734, 0, -0.0153780650, -0.1529753359, 1.1683534008, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: raw
    aliases: [Raw, Non-Color, Utility - Raw]
    isdata: true
)";

// Names of scene-linear Rec. 709 in common configurations.
constexpr const char* linear_names[] = {
    "lin_rec709",       "Linear Rec.709 (sRGB)",   "lin_rec709_srgb",
    "lin_rec709_scene", "Linear Rec.709",          "lin_srgb",
    "Linear sRGB",      "Utility - Linear - sRGB", "Utility - Linear - Rec.709"};

ocio::ConstConfigRcPtr built_in() {
  std::istringstream text(built_in_text);
  return ocio::Config::CreateFromStream(text);
}

// Null if $OCIO is not set.
ocio::ConstConfigRcPtr from_environment() {
  const char* path = std::getenv("OCIO");
  if (!path || !*path) return nullptr;
  try {
    return ocio::Config::CreateFromFile(path);
  } catch (const std::exception& e) {
    throw Error("color-config", std::string("cannot read the configuration of $OCIO: ") + e.what(),
                "correct the environment variable OCIO, or unset it to use the built-in configuration");
  }
}

ocio::ConstProcessorRcPtr processor_of(const std::string& name) {
  if (const auto user = from_environment(); user && user->getColorSpace(name.c_str())) {
    for (const char* linear : linear_names)
      if (user->getColorSpace(linear)) return user->getProcessor(name.c_str(), linear);
    return ocio::Config::GetProcessorFromConfigs(user, name.c_str(), built_in(), "lin_rec709");
  }
  const auto config = built_in();
  if (config->getColorSpace(name.c_str())) return config->getProcessor(name.c_str(), "lin_rec709");
  std::string known;
  for (const auto& n : colorspace_names()) known += (known.empty() ? "" : ", ") + n;
  throw Error("unknown-colorspace", "unknown color space '" + name + "'", "use auto or one of: " + known)
      .parameter("colorspace");
}

bool has_view(const ocio::Config& config, const std::string& display, const std::string& view) {
  for (int i = 0; i < config.getNumViews(display.c_str()); ++i)
    if (view == config.getView(display.c_str(), i)) return true;
  return false;
}

// Resolves "view" or "display/view"; the names themselves may contain slashes.
ocio::DisplayViewTransformRcPtr view_transform(const ocio::Config& config, const std::string& name) {
  std::string display = config.getDefaultDisplay(), view = name;
  if (name.empty()) view = config.getDefaultView(display.c_str());
  for (std::size_t slash = 0; !has_view(config, display, view);) {
    slash = name.find('/', slash);
    if (slash == std::string::npos) {
      std::string known;
      for (int d = 0; d < config.getNumDisplays(); ++d)
        for (int v = 0; v < config.getNumViews(config.getDisplay(d)); ++v)
          known += (known.empty() ? "" : ", ") + std::string(config.getDisplay(d)) + "/" +
                   config.getView(config.getDisplay(d), v);
      throw Error("unknown-view", "the configuration of $OCIO has no view '" + name + "'",
                  "use one of: " + known)
          .parameter("view");
    }
    display = name.substr(0, slash);
    view = name.substr(slash + 1);
    ++slash;
  }
  auto t = ocio::DisplayViewTransform::Create();
  t->setDisplay(display.c_str());
  t->setView(view.c_str());
  return t;
}

}  // namespace

void show_through_view(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& view) {
  const auto config = from_environment();
  if (!config)
    throw Error("no-color-config",
                "view requires an OpenColorIO configuration, but the environment variable OCIO is not set",
                "set the environment variable OCIO, or set tone: neutral")
        .parameter("tone");
  try {
    const auto transform = view_transform(*config, view);
    const char* source = nullptr;
    for (const char* linear : linear_names)
      if (!source && config->getColorSpace(linear)) source = linear;
    if (!source)
      throw Error("color-config", "the configuration of $OCIO has no linear Rec. 709 color space",
                  "add one to the configuration");
    transform->setSrc(source);
    if (width == 0 || height == 0) return;
    ocio::PackedImageDesc picture(pixels, static_cast<long>(width), static_cast<long>(height), 3);
    config->getProcessor(transform)->getDefaultCPUProcessor()->apply(picture);
  } catch (const ocio::Exception& e) {
    throw Error("color-config", std::string("cannot apply the view: ") + e.what(), "set tone: neutral")
        .parameter("view");
  }
  for (std::size_t i = 0; i < width * height; ++i)
    pixels[i] = srgb_to_linear(pixels[i].cwiseMax(0.0f).cwiseMin(1.0f));
}

std::string color_config_id() {
  try {
    const auto user = from_environment();
    return user ? user->getCacheID() : "built-in";
  } catch (const std::exception& e) {
    return std::string("unreadable: ") + e.what();
  }
}

std::vector<std::string> colorspace_names() {
  std::vector<std::string> names;
  auto add = [&](const ocio::ConstConfigRcPtr& c) {
    for (int i = 0; c && i < c->getNumColorSpaces(); ++i) names.push_back(c->getColorSpaceNameByIndex(i));
  };
  add(from_environment());
  add(built_in());
  return names;
}

void to_linear_rec709(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& colorspace) {
  if (width == 0 || height == 0) return;
  try {
    const auto processor = processor_of(colorspace)->getDefaultCPUProcessor();
    ocio::PackedImageDesc picture(pixels, static_cast<long>(width), static_cast<long>(height), 3);
    processor->apply(picture);
  } catch (const ocio::Exception& e) {
    throw Error("color-config",
                "cannot convert from '" + colorspace + "' to scene-linear Rec. 709: " + e.what(),
                "use a configuration with a linear Rec. 709 space or the role aces_interchange")
        .parameter("colorspace");
  }
}

}  // namespace terrazzo
