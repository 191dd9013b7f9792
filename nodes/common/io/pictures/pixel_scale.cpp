#include "nodes/common/io/pictures/pixel_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

namespace terrazzo {
namespace {

// The value of "name=" in lines of text; "" if there is none.
std::string line_value(const std::string& text, const std::string& name) {
  std::size_t at = text.rfind(name + "=", 0) == 0 ? 0 : text.find("\n" + name + "=");
  if (at == std::string::npos) return {};
  at = text.find('=', at) + 1;
  return text.substr(at, text.find_first_of("\r\n", at) - at);
}

std::optional<PixelScale> of_imagej(const PictureDecoder& in) {
  const std::string text = in.text("ImageDescription");
  if (text.rfind("ImageJ=", 0) != 0) return {};
  const std::string unit = line_value(text, "unit");
  const double per_unit = in.number("XResolution"), mm = mm_of_unit(unit);
  if (mm <= 0 || per_unit <= 0) return {};
  return PixelScale{mm / per_unit, 0.01,
                    fmt::format("its calibration in ImageJ, {:g} pixels per {}", per_unit, unit)};
}

std::optional<PixelScale> of_camera(const PictureDecoder& in) {
  const double distance = 1000 * in.number("Exif:SubjectDistance");
  const double focal = in.number("Exif:FocalLength");
  if (distance <= 0 || focal <= 0 || distance <= 2 * focal) return {};
  const double longest = std::max(in.header().width, in.header().height);
  double per_focal = 0, uncertainty = 0;  // pitch of the present pixels / focal length
  const double resolution = in.number("Exif:FocalPlaneXResolution");
  if (resolution > 0) {
    static constexpr double kUnits[6] = {0, 0, 25.4, 10, 1, 0.001};
    const int unit = in.whole("Exif:FocalPlaneResolutionUnit", 2);
    const double mm = unit >= 2 && unit <= 5 ? kUnits[unit] : 0;
    // The picture may have been reduced since it was taken.
    const double taken = std::max(in.whole("Exif:PixelXDimension"), in.whole("Exif:PixelYDimension"));
    per_focal = mm / resolution * (taken > 0 ? taken / longest : 1) / focal;
    uncertainty = 0.1;
  } else if (const int equivalent = in.whole("Exif:FocalLengthIn35mmFilm"); equivalent > 0) {
    per_focal = 36.0 / longest / equivalent;
    uncertainty = 0.15;
  }
  if (per_focal <= 0) return {};
  return PixelScale{
      (distance - focal) * per_focal, uncertainty,
      fmt::format("EXIF data, focal length {:g} mm and subject distance {:g} m", focal, distance / 1000)};
}

std::optional<PixelScale> of_scan(const PictureDecoder& in) {
  if (in.number("Exif:FocalLength") > 0 || in.number("ExposureTime") > 0 || in.number("FNumber") > 0)
    return {};
  const double x = in.number("XResolution"), y = in.number("YResolution", x);
  const std::string unit = in.text("ResolutionUnit");
  const double mm = unit == "in" ? 25.4 : unit == "cm" ? 10 : 0;
  if (mm <= 0 || x <= 0 || std::abs(x - y) > 0.001 * x) return {};
  const double per_inch = 25.4 * x / mm;
  for (const double habit : {72, 96, 180, 240, 300})
    if (std::abs(per_inch - habit) < 0.6) return {};
  return PixelScale{mm / x, 0.01,
                    fmt::format("its resolution, {:g} pixels per {}", x, mm > 20 ? "inch" : "cm")};
}

}  // namespace

double mm_of_unit(const std::string& unit) {
  static constexpr std::array<std::pair<std::string_view, double>, 16> kKnown{{{"nm", 1e-6},
                                                                               {"um", 1e-3},
                                                                               {"nanometer", 1e-6},
                                                                               {"micrometer", 1e-3},
                                                                               {"millimeter", 1},
                                                                               {"µm", 1e-3},
                                                                               {"μm", 1e-3},
                                                                               {"\\u00B5m", 1e-3},
                                                                               {"micron", 1e-3},
                                                                               {"microns", 1e-3},
                                                                               {"mm", 1},
                                                                               {"cm", 10},
                                                                               {"m", 1000},
                                                                               {"inch", 25.4},
                                                                               {"inches", 25.4},
                                                                               {"in", 25.4}}};
  for (const auto& [name, mm] : kKnown)
    if (unit == name) return mm;
  return 0;
}

std::optional<PixelScale> pixel_scale_of(const PictureDecoder& in) {
  std::optional<PixelScale> scale = of_imagej(in);
  if (!scale) scale = of_camera(in);
  if (!scale) scale = of_scan(in);
  // Between a nanometer and a meter; else the metadata are wrong.
  if (scale && !(scale->size >= 1e-6 && scale->size <= 1000)) scale.reset();
  return scale;
}

std::optional<double> field_of_view_of(const PictureDecoder& in) {
  const int equivalent = in.whole("Exif:FocalLengthIn35mmFilm");
  if (equivalent <= 0) return {};  // 0 means unknown
  const double degrees = 2 * std::atan(18.0 / equivalent) * 180 / std::numbers::pi;
  if (degrees < 1 || degrees > 170) return {};  // no camera for surfaces
  return degrees;
}

}  // namespace terrazzo
