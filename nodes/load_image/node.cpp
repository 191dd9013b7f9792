#include "graph/node_type.h"
#include "nodes/common/color_config.h"
#include "nodes/common/image_file.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  if (c.text("color_config") != color_config_id())
    throw Error(
        "color-config",
        "the colour configuration is '" + color_config_id() + "', not '" + c.text("color_config") + "'",
        "set the variable OCIO to the configuration that the graph was written for, or leave color_config "
        "out")
        .parameter("color_config");
  const auto& files = c.files("path");
  const std::string colorspace = c.text("colorspace");
  Image stack;
  for (std::size_t i = 0; i < files.size(); ++i) {
    c.work().check();
    Image section = read_image(files[i], colorspace, c.number("pixel_size"), reading_of(c));
    if (i == 0) {
      stack = std::move(section);
      require_memory(
          static_cast<double>(sizeof(Vec3f)) * static_cast<double>(stack.pixels.size() * files.size()),
          c.memory(), std::to_string(files.size()) + " pictures");
      stack.pixels.reserve(stack.pixels.size() * files.size());
    } else {
      if (section.width != stack.width || section.height != stack.height)
        throw Error("unequal-sections",
                    "'" + files[i].string() + "' is " + std::to_string(section.width) + " × " +
                        std::to_string(section.height) + " pixels, '" + files[0].string() + "' " +
                        std::to_string(stack.width) + " × " + std::to_string(stack.height),
                    "sections of one stack must have one size and scale")
            .parameter("path");
      stack.pixels.insert(stack.pixels.end(), section.pixels.begin(), section.pixels.end());
      ++stack.sections;
    }
    c.work().progress(static_cast<double>(i + 1) / static_cast<double>(files.size()));
  }
  c.metric("width", stack.width);
  c.metric("height", stack.height);
  c.metric("sections", stack.sections);
  c.output("image", std::move(stack));
}

}  // namespace

NodeType load_image_node() {
  return NodeType("LoadImage", 2)
      .doc_(
          "Reads a photograph, or a stack of them, as scene-linear Rec. 709: JPEG, PNG, TIFF, OpenEXR, "
          "Radiance HDR, "
          "BMP or PNM, with color spaces through OpenColorIO. A file that was cut short is an error; what "
          "its decoder "
          "complains about is a warning.")
      .output("image", "Image", "one section a file, in the order of the names")
      .parameter(Parameter::input_path("path").doc_(
          "Picture; a glob names a stack of sections of equal size and scale"))
      .parameter(Parameter::number("pixel_size", 1).unit_("mm").above(0).doc_("Edge of a pixel"))
      .parameter(Parameter::text("colorspace", "auto")
                     .doc_("OpenColorIO name of the files' colour space; auto: sRGB for integer formats, "
                           "scene-linear for "
                           "float ones. Looked up in $OCIO where set, then in the built-in configuration"))
      .parameter(Parameter::text("color_config", color_config_id())
                     .doc_("Identity of the colour configuration in force, so that a changed $OCIO is a "
                           "changed input. "
                           "Write it only to insist on one"))
      .compute_(compute);
}

}  // namespace terrazzo
