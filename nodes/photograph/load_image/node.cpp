#include <fmt/format.h>

#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/io/image_file.h"
#include "nodes/common/io/pictures/color_config.h"
#include "nodes/common/io/pictures/georeferences.h"
#include "nodes/photograph/load_image/rectify.h"
#include "runtime/context.h"

namespace terrazzo::load_image {
namespace {

// The metadata may be wrong, so they never set the size of a pixel; users who left the default should
// know.
void offer(const PixelScale& scale, Context& c) {
  if (std::abs(c.number("pixel_size") - scale.size) <= scale.uncertainty * scale.size) return;
  c.warn(fmt::format(
      "according to {}, a pixel is {:.3g} mm wide (± {:.0f} %), but pixel_size is {:g}; if the metadata "
      "are right, set pixel_size: {:.3g}",
      scale.source, scale.size, 100 * scale.uncertainty, c.number("pixel_size"), scale.size));
}

// The place of the first file, which must agree with pixel_size; none if the picture does not keep it.
std::optional<Georeference> place_of(Context& c, const StatedSizes& sizes) {
  const auto& place = sizes.place;
  if (!place) return {};
  const auto leave = [&](const std::string& why) {
    c.warn(fmt::format("the coordinates of {} are not kept: {}", place->source, why));
    return std::nullopt;
  };
  if (c.files("path").size() > 1) return leave("a stack has no single place");
  if (c.number("tilt") > 0) return leave("tilt changes the picture");
  if (place->unit == 0)
    return leave("their unit is not known to be a length. Reproject the picture to meters");
  if (sizes.turned)
    throw Error("bad-georeference",
                "'" + c.files("path")[0].string() + "' is georeferenced, but stored mirrored or turned",
                "write it upright")
        .parameter("path");
  const Georeference& g = place->georeference;
  const double size = std::hypot(g.m[0], g.m[3]) * place->unit;
  if (std::abs(c.number("pixel_size") - size) > 1e-3 * size)
    throw Error("contradicting-unit",
                fmt::format("according to {}, a pixel is {:.6g} mm wide, but pixel_size is {:g}",
                            place->source, size, c.number("pixel_size")),
                fmt::format("set pixel_size: {:.6g}, or remove the georeference if it is wrong", size))
        .parameter("pixel_size");
  return g;
}

// How the camera looked at the surface. `stated`: the field of view according to the first file.
TiltOptions tilt_of(Context& c, std::optional<double> stated) {
  constexpr double kPhone = 60;  // degrees across the longer side, of the main cameras of phones
  TiltOptions out{c.number("tilt"), c.number("tilt_direction"), kPhone};
  if (const auto given = c.optional_number("field_of_view"))
    out.field_of_view = *given;
  else if (stated)
    out.field_of_view = *stated;
  else if (out.tilt > 0)
    c.warn(fmt::format(
        "the file does not state the camera's field of view; {:g}° across the longer side are assumed, as of "
        "a phone's main camera. If it was another, set field_of_view",
        kPhone));
  if (out.tilt > 0) c.metric("field_of_view", out.field_of_view);
  return out;
}

void compute(Context& c) {
  if (c.text("color_config") != color_config_id())
    throw Error("color-config",
                "the color configuration is '" + color_config_id() + "', but the graph asks for '" +
                    c.text("color_config") + "'",
                "set the environment variable OCIO to the configuration that the graph was written for, or "
                "remove color_config from the graph")
        .parameter("color_config");
  const auto& files = c.files("path");
  const std::string colorspace = c.text("colorspace");
  const PageOptions choice = page_choice(c);
  Image stack;
  TiltOptions tilt;
  for (std::size_t i = 0; i < files.size(); ++i) {
    c.work().check();
    StatedSizes sizes;
    Image section = read_image(files[i], colorspace, c.number("pixel_size"), reading_of(c),
                               i == 0 ? &sizes : nullptr, choice);
    if (i == 0) {
      if (!sizes.place) sizes.place = place_beside(files[i], reading_of(c));
      section.georeference = place_of(c, sizes);
      if (sizes.pixel && !(sizes.place && sizes.place->unit > 0)) offer(*sizes.pixel, c);
      tilt = tilt_of(c, sizes.field_of_view);
    }
    if (tilt.tilt > 0) section = rectified(section, tilt, c.memory(), c.work().quiet());
    if (i == 0) {
      stack = std::move(section);
      require_memory(static_cast<double>(sizeof(Vec3f)) * (stack.pixels.size() * files.size()), c.memory(),
                     std::to_string(files.size()) + " images");
      stack.pixels.reserve(stack.pixels.size() * files.size());
    } else {
      if (section.width != stack.width || section.height != stack.height)
        throw Error("size-mismatch",
                    "'" + files[i].string() + "' is " + std::to_string(section.width) + " × " +
                        std::to_string(section.height) + " pixels, but '" + files[0].string() + "' " +
                        std::to_string(stack.width) + " × " + std::to_string(stack.height),
                    "all sections of a stack must have the same size and scale")
            .parameter("path");
      stack.pixels.insert(stack.pixels.end(), section.pixels.begin(), section.pixels.end());
      ++stack.sections;
    }
    c.work().done(i + 1, files.size());
  }
  c.metric("width", stack.width);
  c.metric("height", stack.height);
  c.metric("sections", stack.sections);
  c.output("image", std::move(stack));
}

}  // namespace
}  // namespace terrazzo::load_image

namespace terrazzo {

NodeType load_image_node() {
  using namespace load_image;
  return NodeType("LoadImage", 6)
      .doc_(
          "Reads a photograph, or a stack of section photographs, as scene-linear Rec. 709. Formats: JPEG, "
          "PNG, TIFF, OpenEXR, Radiance HDR, BMP, PNM, GIF and the raw files of cameras; color spaces are "
          "converted "
          "through OpenColorIO and Little CMS. A truncated file is an error; other decoder messages become "
          "warnings.")
      .source_("GeoTIFF 1.1; EXIF 2.32")
      .output("image", "Image",
              "One section per file, in file name order. A single one keeps its coordinates on the map, for "
              "files of "
              "outlines and tables of profiles.")
      .parameter(Parameter::input_path("path").doc_(
          "Image file. A glob names a stack of sections of equal size and scale."))
      .parameter(
          Parameter::number("pixel_size", 1)
              .unit_("mm")
              .range(1e-9, 1e9)
              .doc_("Edge length of a pixel. A warning appears if the file's metadata (EXIF, scanner "
                    "resolution, ImageJ calibration) state another size. Another size in a georeference "
                    "(GeoTIFF tags, or a world file such as .jgw, in meters) is an error."))
      .parameter(Parameter::text("colorspace", "auto")
                     .doc_("OpenColorIO name of the files' color space, looked up in the configuration of "
                           "$OCIO if set, then in the built-in one. auto: what the file states (ICC profile, "
                           "PNG chunks, EXIF, OpenEXR chromaticities), else sRGB for integer formats and "
                           "scene-linear for float formats."))
      .parameter(Parameter::optional_integer("page", "auto")
                     .range(1, 1e6)
                     .doc_("Page to read of a file with several, from 1. auto: the only one."))
      .parameter(Parameter::optional_integer("channel", "auto")
                     .range(1, 10000)
                     .doc_("Channel to read as gray, from 1. auto: the colors, or the only one."))
      .parameter(Parameter::number("tilt", 0).unit_("degrees").range(0, 60).doc_(
          "Angle between the camera's axis and the normal of the surface. Above 0, the "
          "photograph is projected onto the surface and cut to the largest rectangle "
          "without missing pixels; pixel_size then holds at the middle of the photograph, "
          "across tilt_direction."))
      .parameter(Parameter::number("tilt_direction", 90)
                     .unit_("degrees")
                     .range(-360, 360)
                     .doc_("Where in the picture the surface recedes, if tilt is above 0. 0: to the right. "
                           "90: up."))
      .parameter(Parameter::optional_number("field_of_view", "auto")
                     .unit_("degrees")
                     .range(1, 170)
                     .doc_("Angle that the camera saw across the picture's longer side, if tilt is above 0. "
                           "auto: from EXIF's 35 mm equivalent focal length, else 60."))
      .parameter(Parameter::text("color_config", color_config_id())
                     .doc_("Identity of the OpenColorIO configuration in use, so that a changed $OCIO counts "
                           "as a changed input. Set it only to require a particular configuration."))
      .companion_files_(world_files)
      .compute_(compute);
}

}  // namespace terrazzo
