#include "nodes/common/io/pictures/georeferences.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "graph/text/read_number.h"
#include "nodes/common/io/pictures/tiff_directory.h"
#include "nodes/common/io/text_input.h"

namespace terrazzo {
namespace {

constexpr double kMmPerMeter = 1000;
constexpr double kSquare = 1e-3;  // relative difference of a pixel's edges, and sine of their angle to 90°

// Tags of GeoTIFF 1.1, and keys in its directory.
constexpr std::uint64_t kPixelScale = 33550, kTiepoints = 33922, kTransformation = 34264, kKeys = 34735;
constexpr std::uint64_t kModelType = 1024, kRasterType = 1025, kProjected = 3072, kLinearUnit = 3076;
constexpr std::uint64_t kModelProjected = 1, kPixelIsPoint = 2, kUserDefined = 32767;

Error bad_place(const std::filesystem::path& path, const std::string& what, const std::string& hint) {
  return Error("bad-georeference", fmt::format("'{}': {}", path.string(), what), hint).parameter("path");
}

// Throws unless pixels are squares of a size.
void require_squares(const Georeference& g, const std::filesystem::path& path) {
  const Vec2 x(g.m[0], g.m[3]), y(g.m[1], g.m[4]);
  for (const double v : g.m)
    if (!std::isfinite(v)) throw bad_place(path, "its georeference is not finite", "correct it");
  if (!(x.norm() > 0) || !(y.norm() > 0))
    throw bad_place(path, "its georeference gives pixels no size", "correct it");
  if (std::abs(x.norm() - y.norm()) > kSquare * x.norm() ||
      std::abs(x.dot(y)) > kSquare * x.norm() * y.norm())
    throw bad_place(
        path,
        fmt::format("its georeference says that pixels are no squares: edges ({:g}, {:g}) and ({:g}, {:g})",
                    x.x(), x.y(), y.x(), y.y()),
        "resample the picture to square pixels, for example with gdalwarp -tr");
}

// The center of the first pixel is at (½, ½).
void refer_to_corner(Georeference& g) {
  g.m[2] -= (g.m[0] + g.m[1]) / 2;
  g.m[5] -= (g.m[3] + g.m[4]) / 2;
}

class GeoTags {
 public:
  GeoTags(const PictureContent& content, const PicturePage& page)
      : path_(content.path), in_(content.bytes), directory_(in_.directory(page.directory)) {}

  const TiffDirectory& directory() const { return directory_; }
  bool any() const {
    return directory_.entries.count(kPixelScale) || directory_.entries.count(kTransformation);
  }

  std::vector<double> doubles(std::uint64_t tag, std::size_t least) const {
    std::vector<double> out;
    const auto found = directory_.entries.find(tag);
    if (found == directory_.entries.end()) return out;
    constexpr std::uint64_t kDouble = 12, kMost = 10000;
    if (found->second.type != kDouble || found->second.count < least || found->second.count > kMost)
      throw bad_place(path_, fmt::format("its GeoTIFF tag {} is damaged", tag), "write the file again");
    for (std::uint64_t i = 0; i < found->second.count; ++i)
      out.push_back(std::bit_cast<double>(in_.number(found->second.at + 8 * i, 8)));
    return out;
  }

  // The value of a key, or 0.
  std::uint64_t key(std::uint64_t wanted) const {
    const auto found = directory_.entries.find(kKeys);
    if (found == directory_.entries.end() || found->second.width != 2) return 0;
    for (std::uint64_t i = 4; i + 3 < found->second.count; i += 4)
      if (in_.value(found->second, i) == wanted && in_.value(found->second, i + 1) == 0)
        return in_.value(found->second, i + 3);
    return 0;
  }

 private:
  const std::filesystem::path& path_;
  TiffReader in_;
  TiffDirectory directory_;
};

// mm per unit of the map; 0 for degrees and units without a length. Projected maps without a unit are in
// meters.
double unit_of(const GeoTags& tags) {
  if (tags.key(kModelType) != kModelProjected) return 0;
  constexpr std::uint64_t kMeter = 9001, kFoot = 9002, kSurveyFoot = 9003;
  switch (tags.key(kLinearUnit)) {
    case 0:
    case kMeter:
      return kMmPerMeter;
    case kFoot:
      return 304.8;
    case kSurveyFoot:
      return kMmPerMeter * 1200 / 3937;
    default:
      return 0;
  }
}

}  // namespace

std::optional<StatedPlace> place_in_tiff(const PictureContent& content, const PicturePage& page) {
  if (content.format != "tiff") return {};
  const GeoTags tags(content, page);
  if (!tags.any()) return {};
  StatedPlace out;
  out.source = "its GeoTIFF tags";
  Georeference& g = out.georeference;
  if (const auto t = tags.doubles(kTransformation, 16); !t.empty()) {
    g.m = {t[0], t[1], t[3], t[4], t[5], t[7]};
  } else {
    const auto scale = tags.doubles(kPixelScale, 2), tie = tags.doubles(kTiepoints, 6);
    if (tie.size() != 6)
      throw bad_place(content.path,
                      fmt::format("its GeoTIFF tags have {} tie points instead of one", tie.size() / 6),
                      "rectify the picture, for example with gdalwarp");
    g.m = {scale[0], 0, tie[3] - tie[0] * scale[0], 0, -scale[1], tie[4] + tie[1] * scale[1]};
  }
  if (tags.key(kRasterType) == kPixelIsPoint) refer_to_corner(g);
  const auto system = tags.key(kProjected);
  g.epsg = system > 0 && system < kUserDefined ? static_cast<int>(system) : 0;
  out.unit = unit_of(tags);
  if (out.unit > 0) require_squares(g, content.path);
  return out;
}

std::vector<std::filesystem::path> world_files(const std::filesystem::path& picture) {
  const std::string extension = picture.extension().string();
  if (extension.size() < 3) return {};
  const auto named = [&](const std::string& end) {
    return std::filesystem::path(picture).replace_extension(end);
  };
  const std::string brief{'.', extension[1], extension.back(), 'w'};
  std::error_code error;
  for (const std::filesystem::path& file : {named(brief), named(extension + "w"), named(".wld")})
    if (std::filesystem::is_regular_file(file, error)) return {file};
  return {};
}

std::optional<StatedPlace> place_beside(const std::filesystem::path& picture, const Reading& reading) {
  for (const std::filesystem::path& path : world_files(picture)) {
    const std::string text = read_text(path, reading);
    std::array<double, 6> v{};
    std::size_t count = 0, at = 0;
    while (at < text.size()) {
      const std::size_t from = text.find_first_not_of(" \t\r\n", at);
      if (from == std::string::npos) break;
      at = std::min(text.find_first_of(" \t\r\n", from), text.size());
      const auto number = read_number(std::string_view(text).substr(from, at - from));
      if (!number || count == v.size())
        throw bad_place(path, "a world file has six lines, each a number", "correct it, or rename it");
      v[count++] = *number;
    }
    if (count != v.size())
      throw bad_place(path, fmt::format("a world file has six lines, not {}", count),
                      "correct it, or rename it");
    StatedPlace out;
    out.georeference.m = {v[0], v[2], v[4], v[1], v[3], v[5]};
    refer_to_corner(out.georeference);
    require_squares(out.georeference, path);
    out.unit = kMmPerMeter;
    out.source = fmt::format("'{}'", path.filename().string());
    return out;
  }
  return {};
}

}  // namespace terrazzo
